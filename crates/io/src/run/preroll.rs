//! Pre-roll: lets the bodies of a scene settle before frame 0.

use std::borrow::Cow;

use supple::{Error, Simulation};

use crate::scene::Scene;

/// Simulates the pre-roll of a simulation that [`prepare`](super::prepare()) built: `seconds`, rounded up to whole frames,
/// before the time 0, at which it ends. Keyframes have their first values before the first of them, and pins and handles
/// that start at the time 0 act from the beginning. After each frame, calls `proceed` with the share of the time that is
/// done. Returns whether `proceed` returned true each time.
///
/// # Errors
///
/// A time out of range.
pub fn preroll(
    simulation: &mut Simulation,
    seconds: f64,
    mut proceed: impl FnMut(f64) -> bool,
) -> Result<bool, Error> {
    let fps = simulation.fps().unwrap_or(1.0 / simulation.dt());
    let frames = whole_frames(seconds, fps) as u64;
    if frames == 0 {
        return Ok(true);
    }
    let substeps = simulation.substeps();
    simulation.set_time(-((frames * substeps) as f64 * simulation.dt()))?;
    for frame in 1..=frames {
        simulation.steps(substeps);
        if !proceed(frame as f64 / frames as f64) {
            return Ok(false);
        }
    }
    if simulation.time() != 0.0 {
        simulation.set_time(0.0)?;
    }
    Ok(true)
}

/// Returns the number of frames of a pre-roll.
fn whole_frames(seconds: f64, fps: f64) -> f64 {
    // The factor keeps a rounding error from adding a frame.
    (seconds * fps * (1.0 - 1e-9)).ceil()
}

/// Returns a scene whose pins and handles that start at the time 0 start with the pre-roll, if there is one.
pub(super) fn with_early_starts(scene: &Scene) -> Cow<'_, Scene> {
    let seconds = scene.simulation.preroll;
    if seconds == 0.0 {
        return Cow::Borrowed(scene);
    }
    let mut scene = scene.clone();
    let start = -whole_frames(seconds, scene.simulation.fps) / scene.simulation.fps;
    for body in &mut scene.bodies {
        let pins = body.pins.iter_mut().map(|pin| &mut pin.window);
        let windows = pins.chain(body.handles.iter_mut().map(|handle| &mut handle.window));
        windows.filter(|window| window.start == 0.0).for_each(|window| window.start = start);
    }
    Cow::Owned(scene)
}

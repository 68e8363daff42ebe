//! Continues a run from a frame in its middle, with a scene that may have changed: [`Job::from`].

use std::path::Path;

use supple::SimulationState;

use super::changes::Changes;
use super::checkpoint::{CHECKPOINT, Saved};
use super::error::RunError;
use super::job::{Job, Resume};
use super::prepare::Prepared;
use super::resume::Earlier;
use super::settings::Settings;
use super::states;
use crate::frames::{Listing, Present, Record, check, check_link};

impl Job {
    /// Checks [`Job::from`].
    pub(super) fn check_from(&self) -> Result<(), RunError> {
        let Some(from) = self.from else { return Ok(()) };
        if self.resume != Resume::No {
            let (value, range) =
                (from.to_string(), "left out with `resume`, which continues after the last checkpoint");
            return Err(RunError::Option { option: "from", value, range });
        }
        if u64::from(from) < self.number(0) {
            let (value, range) = (from.to_string(), "at least the number of the first frame, `start_frame`");
            return Err(RunError::Option { option: "from", value, range });
        }
        let last = self.number(self.scene.simulation.frames);
        if u64::from(from) >= last && u64::from(from) > self.number(0) {
            let (value, range) =
                (format!("{from}, and the last frame is {last}"), "less than the last frame");
            return Err(RunError::Option { option: "from", value, range });
        }
        Ok(())
    }

    /// Returns whether the job keeps a state after frame `frame`, counted from 0.
    pub(super) fn keeps_state(&self, frame: u32) -> bool {
        frame > 0 && self.scene.output.states.is_some_and(|interval| frame.is_multiple_of(interval.max(1)))
    }

    /// Returns the earlier run up to the newest kept state or checkpoint at or before the frame with the number `from`.
    /// Changes no file.
    pub(super) fn find_state(&self, settings: &Settings, from: u64) -> Result<Earlier, RunError> {
        let saved = self.newest_state(from)?;
        let path = saved.path().to_owned();
        let failed = |what: String, is_change| RunError::From { path: path.clone(), what, is_change };
        let refused = |what: String| failed(what, false);
        let before = &saved.checkpoint.settings;
        // The scene of another version may have other keys. A change of the scene can be one of the files too.
        let changes = match before.version == settings.version {
            true => Changes::between(&before.fingerprint, &settings.fingerprint)
                .map_err(|change| failed(format!("{change}, and a state depends on it"), true))?,
            false => Changes::default(),
        };
        let of_files = Settings { fingerprint: settings.fingerprint.clone(), ..before.clone() };
        if let Some(difference) = of_files.difference(settings) {
            return Err(failed(difference, true));
        }
        let sequences = self.sequences();
        let saved = saved.checked(settings, sequences.len())?;
        let complete = |sequence: &&crate::frames::Sequence| {
            sequence.format.needs_all_frames() && sequence.path(0).symlink_metadata().is_ok()
        };
        if let Some(sequence) = sequences.iter().find(complete) {
            return Err(refused(format!(
                "the format `{}` keeps no single frames once its file is complete, so that {} cannot be continued; \
                 write obj, ply, pc2, usd, html or vtu",
                sequence.format,
                sequence.path(0).display()
            )));
        }
        let records: Vec<&[Record]> = saved.checkpoint.frames.iter().map(Vec::as_slice).collect();
        let listing = Listing::read(&sequences)?;
        let renames = match check(&listing, &sequences, &records, (self.compare(), true))? {
            Present::All(renames) => renames,
            Present::Not(reason) => return Err(refused(reason)),
        };
        let stats = self.kept_rows(&saved.checkpoint)?;
        sequences.iter().try_for_each(check_link)?;
        Earlier::new(saved, stats, (listing, renames), Some(changes))
    }

    /// Returns the newest kept state or checkpoint at or before the frame with the number `from`.
    fn newest_state(&self, from: u64) -> Result<Saved, RunError> {
        let states = states::list(&self.directory)?;
        let kept = states.iter().rev().find(|state| state.number <= from);
        let checkpoint = Saved::open(&self.directory.join(CHECKPOINT));
        let number = |saved: &Saved| {
            u64::from(saved.checkpoint.settings.start_frame) + u64::from(saved.checkpoint.frame)
        };
        let checkpoint = match (checkpoint, kept) {
            // A state can be good where the checkpoint is damaged.
            (Err(_), Some(_)) => None,
            (checkpoint, _) => checkpoint?,
        };
        let of_checkpoint = checkpoint.as_ref().map(number);
        if let (Some(checkpoint), Some(number)) = (checkpoint, of_checkpoint)
            && number <= from
            && kept.is_none_or(|state| state.number < number)
        {
            return Ok(checkpoint);
        }
        match kept {
            Some(state) => {
                let saved = Saved::open(&state.path)?;
                let saved = saved.filter(|saved| number(saved) == state.number);
                saved.ok_or_else(|| RunError::From {
                    path: state.path.clone(),
                    what: "it is not the state of the frame in its name; remove it".to_owned(),
                    is_change: false,
                })
            }
            None => Err(RunError::NoState {
                directory: self.directory.clone(),
                from,
                first: states.first().map(|state| state.number).into_iter().chain(of_checkpoint).min(),
            }),
        }
    }
}

impl Prepared {
    /// Restores the state of an earlier run. If the scene has `changes`, the simulation continues with the settings of
    /// the scene. `path`: file of the state, for messages.
    pub(super) fn restore(
        &mut self,
        state: &SimulationState,
        changes: Option<&Changes>,
        path: &Path,
    ) -> Result<(), RunError> {
        let simulation = &mut self.simulation;
        let restored = match changes.filter(|changes| changes.any) {
            None => simulation.restore(state),
            Some(Changes { bodies, colliders, .. }) => {
                let built = simulation.state();
                let state = state.clone().for_adoption(bodies);
                simulation.restore(&state).and_then(|()| {
                    simulation.adopt(&built, bodies)?;
                    if *colliders {
                        // As if they were set: bodies inside of them leave them whole.
                        let description = |index| simulation.collider(index).description().clone();
                        let list: Vec<_> = (0..simulation.collider_count()).map(description).collect();
                        simulation.set_colliders(&list)?;
                    }
                    Ok(())
                })
            }
        };
        if let Err(error) = restored {
            let (path, what) = (path.to_owned(), error.to_string());
            return Err(match changes {
                None => RunError::Checkpoint { path, what },
                Some(_) => RunError::From { path, what, is_change: false },
            });
        }
        if changes.is_some_and(|changes| changes.any) {
            self.substeps = self.simulation.substeps() as u32;
        }
        Ok(())
    }
}

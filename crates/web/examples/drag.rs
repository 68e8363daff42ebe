//! Drags the bust as the browser test does, and writes the positions after each second as 32-bit floats.
//!
//!     cargo run -p supple-web --example drag -- MODEL.obj OUT.bin

use std::error::Error;
use std::path::PathBuf;

use supple_web::{Playground, Settings};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(model), Some(out)) = (arguments.next(), arguments.next()) else {
        return Err("expected MODEL.obj OUT.bin".into());
    };
    let mut playground = Playground::new("model.obj", std::fs::read(model)?, &Settings::default())?;
    let mut bytes = Vec::new();
    playground.grab(1, 0.0, 0.7, 0.0)?;
    for frame in 0..180 {
        if frame < 120 {
            playground.drag(1, 0.0025 * f64::from(frame), 0.00125 * f64::from(frame), 0.0)?;
        } else {
            playground.release(1)?;
        }
        playground.advance(1)?;
        if frame % 60 == 59 {
            playground.evaluate();
            bytes.extend(playground.surface().as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        }
    }
    std::fs::write(out, bytes)?;
    Ok(())
}

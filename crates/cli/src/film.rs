//! `supple film`: shows a run on disk as a moving picture.

use supple_io::counted;
use supple_io::film::Coloring;
use supple_io::films::{self, FilmRequest};

use crate::args::{Color, FilmArgs};
use crate::exit::Exit;
use crate::terminal;

/// Writes the film of a run.
pub(crate) fn film(args: &FilmArgs) -> Exit {
    let mut request = FilmRequest::default();
    (request.look.size, request.look.view) = (args.size, args.view);
    request.look.coloring = match args.color {
        Color::Material => Coloring::Material,
        Color::Volume => Coloring::Volume,
    };
    (request.fps, request.threads) = (args.fps, args.threads as usize);
    request.up = args.up.map_or(request.up, Into::into);
    match films::film(&args.input, &args.output, &request) {
        Ok(frames) => {
            terminal::print(format_args!("{} in {}", counted(frames, "frame"), args.output.display()));
            Exit::Done
        }
        Err(error) => {
            terminal::print_error(&error);
            if error.is_input() { Exit::Input } else { Exit::Failed }
        }
    }
}

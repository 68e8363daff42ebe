//! `supple html`: joins the pages of several runs.

use supple_io::counted;
use supple_io::pages::join;

use crate::args::HtmlArgs;
use crate::exit::Exit;
use crate::terminal;

/// Writes a page with the runs of the arguments side by side.
pub(crate) fn html(args: &HtmlArgs) -> Exit {
    match join(&args.inputs, &args.output) {
        Ok(runs) => {
            terminal::print(format_args!("{} in {}", counted(runs, "run"), args.output.display()));
            Exit::Done
        }
        Err(error) => {
            terminal::print_error(&error);
            if error.is_input() { Exit::Input } else { Exit::Failed }
        }
    }
}

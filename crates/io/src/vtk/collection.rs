//! The files of a motion and their times.

/// Returns the text of a collection of files, each with its time in seconds.
pub(crate) fn collection<'a>(files: impl Iterator<Item = (f64, &'a str)>) -> String {
    let mut text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n".to_owned();
    for (time, name) in files {
        text += &format!("<DataSet timestep=\"{time}\" file=\"{name}\"/>\n");
    }
    text + "</Collection>\n</VTKFile>\n"
}

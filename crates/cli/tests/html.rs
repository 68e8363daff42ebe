//! `supple html`: joins the pages of runs.

mod support;

use support::Workspace;

#[test]
fn runs_are_joined_in_the_order_of_the_arguments() {
    let workspace = Workspace::new();
    for (directory, frames) in [("b", "2"), ("a", "3")] {
        workspace
            .supple(&["run", "scene.toml", "--format", "html", "-o", directory, "--frames", frames])
            .expect(0, &[]);
    }
    let output = workspace.supple(&["html", "b", "a/supple.html", "-o", "both.html"]);
    output.expect(0, &[]);
    assert_eq!(output.out, "2 runs in both.html\n");
    let page = std::fs::read_to_string(workspace.path("both.html")).unwrap();
    assert!(page.contains("<title>b · a · supple</title>"));
    // The default name is that of the documentation.
    workspace.supple(&["html", "b"]).expect(0, &[]);
    assert!(workspace.path("page.html").exists());
}

#[test]
fn invalid_arguments_write_nothing() {
    let workspace = Workspace::new();
    workspace.supple(&["run", "scene.toml", "--frames", "1"]).expect(0, &[]);
    workspace.supple(&["html", "out"]).expect(2, &["out has no page supple.html", "--format obj,html"]);
    workspace.supple(&["html", "none"]).expect(2, &["cannot read none"]);
    workspace.supple(&["html", "scene.toml"]).expect(2, &["scene.toml", "not a page of supple"]);
    workspace.supple(&["html", "out", "-o", "page.txt"]).expect(2, &["-o page.txt", ".html"]);
    workspace.supple(&["html"]).expect(2, &["RUN"]);
    assert!(!workspace.path("page.html").exists() && !workspace.path("page.txt").exists());
}

#[test]
fn changed_formats_are_no_continuation() {
    let workspace = Workspace::new();
    workspace.supple(&["run", "scene.toml", "--frames", "2", "--format", "obj,html"]).expect(0, &[]);
    let resume = |format: &str| {
        workspace.supple(&["run", "scene.toml", "--frames", "3", "--format", format, "--resume"])
    };
    resume("obj").expect(2, &["the format changed from obj,html to obj"]);
    resume("html,obj").expect(2, &["from obj,html to html,obj"]);
    // A format that is given twice counts once.
    resume("obj,html,obj").expect(0, &[]);
}

//! No display, no file, no such line: what goes wrong is said.

use crate::session::{Session, Viewer};

/// Whether it ended with exit code 1 and a message that has these words.
fn fails_with(viewer: Viewer, words: &str) {
    let output = viewer.end();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.starts_with("lumigon: ") && said.contains(words),
        "{said}"
    );
}

#[test]
fn a_window_is_saved_as_large_as_it_is() {
    let session = Session::with("cornell.glb");
    let words = "view cornell.glb --size 640x400 --frames 3 --screenshot window.png --timings";
    let output = session.start(words).end();
    assert!(output.status.success(), "{output:?}");
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 3);
    let window = session.image("window.png");
    assert_eq!(window.size(), [640, 400]);
    assert!(window.mean() > 10.0);
}

#[test]
fn without_a_display_there_is_an_error_and_nothing_else() {
    let mut session = Session::with("cornell.glb");
    session.display.close();
    let words = "view cornell.glb --frames 3 --screenshot window.png --record input.txt";
    fails_with(session.start(words), "no window: ");
    for name in ["window.png", "input.txt"] {
        assert!(!session.path(name).exists(), "{name}");
    }
}

#[test]
fn faults_of_the_input_name_its_line() {
    let session = Session::with("cornell.glb");
    std::fs::write(session.path("input.txt"), "settle\nclimb 1 2\n").unwrap();
    let words = "view cornell.glb --replay input.txt";
    fails_with(
        session.start(words),
        "input.txt, line 2: climb is no action",
    );
    fails_with(
        session.start("view cornell.glb --replay none.txt"),
        "none.txt: ",
    );
    let words = "view cornell.glb --frames 1 --screenshot window.exr";
    fails_with(session.start(words), "the window is saved as .png");
    let words = "view cornell.glb --frames 1 --screenshot none/window.png";
    fails_with(session.start(words), "none");
}

#[test]
fn scenes_that_cannot_be_opened_are_told_in_the_window() {
    let session = Session::with("cornell.glb");
    let whole = std::fs::read(session.path("cornell.glb")).unwrap();
    std::fs::write(session.path("broken.glb"), &whole[..whole.len() / 2]).unwrap();
    session.replay(
        "broken.glb",
        r#"
        settle
        screenshot broken.png
        drop "cornell.glb"
        settle
        screenshot opened.png
        drop "broken.glb"
        settle
        screenshot still.png
        "#,
    );
    for name in ["broken.png", "still.png"] {
        assert!(session.image(name).count([255, 140, 130]) > 100, "{name}");
    }
    // The wall behind the box.
    let wall = |name: &str| session.image(name).part(440, 220, [60, 40]);
    assert!(wall("opened.png").mean() > wall("broken.png").mean() + 20.0);
    assert_eq!(wall("still.png"), wall("opened.png"));
}

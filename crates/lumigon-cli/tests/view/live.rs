//! Without a script: a user's hands, idleness, and a display that goes away.

use std::time::{Duration, Instant};

use crate::session::{Session, Viewer};

/// A window on the Cornell box, once it rests; the number by which the display knows it.
fn open(session: &Session, more: &str) -> (Viewer, String) {
    let viewer = session.start(&format!(
        "view cornell.glb --size 900x600 --backend cpu {more}"
    ));
    let start = Instant::now();
    let window = loop {
        let found = session.display.look("search --name cornell.glb");
        if let Some(window) = found.lines().next() {
            break window.to_owned();
        }
        assert!(start.elapsed() < Duration::from_secs(120), "no window");
        std::thread::sleep(Duration::from_millis(100));
    };
    session.display.hands(&format!("windowfocus {window}"));
    viewer.rest();
    (viewer, window)
}

#[test]
fn hands_do_what_recorded_input_does() {
    let session = Session::with("cornell.glb");
    let (viewer, window) = open(&session, "--record input.txt");
    let hands = |words: &str| {
        session.display.hands(words);
        // As fast as a hand, so that each is in a frame of its own.
        std::thread::sleep(Duration::from_millis(150));
    };
    let title = || session.display.hands(&format!("getwindowname {window}"));
    let picture = |name: &str| {
        hands("key F12");
        hands("key ctrl+a");
        hands(&format!("type --delay 40 {name}"));
        hands("key Return");
        viewer.rest();
        assert!(session.path(name).exists(), "{name}");
    };
    // Turns the camera, then takes hold of the light where it is now.
    for words in [
        "mousemove 400 520",
        "mousedown 1",
        "mousemove 402 524",
        "mousemove 410 530",
        "mouseup 1",
        "key shift+Home",
        "mousemove 460 163",
        "click 1",
        "mousemove 493 157",
        "mousedown 1",
        "mousemove 510 150",
        "mousemove 560 110",
        "mouseup 1",
    ] {
        hands(words);
    }
    viewer.rest();
    assert_eq!(title(), "cornell.glb * - lumigon");
    picture("hands.png");
    hands("key ctrl+z");
    viewer.rest();
    assert_eq!(title(), "cornell.glb - lumigon");
    picture("undone.png");
    hands("key ctrl+q");
    let output = viewer.end();
    assert!(output.status.success(), "{output:?}");

    let recorded = std::fs::read_to_string(session.path("input.txt")).unwrap();
    let [hands, undone] = ["hands.png", "undone.png"].map(|name| {
        let image = session.image(name);
        std::fs::remove_file(session.path(name)).unwrap();
        image
    });
    assert!(hands.difference(&undone) > 50);
    session.replay("cornell.glb", &recorded);
    assert_eq!(session.image("hands.png"), hands, "{recorded}");
    assert_eq!(session.image("undone.png"), undone, "{recorded}");
}

#[test]
fn an_idle_window_does_nothing_and_ends_with_its_display() {
    let mut session = Session::with("cornell.glb");
    let (viewer, window) = open(&session, "");
    let before = viewer.ticks();
    std::thread::sleep(Duration::from_secs(3));
    let ticks = viewer.ticks() - before;
    assert!(
        ticks <= 3,
        "{ticks} hundredths of a second in three seconds"
    );

    // An edit, and time enough to keep it.
    for words in ["mousemove 460 163", "click 1", "key b"] {
        session.display.hands(words);
        std::thread::sleep(Duration::from_millis(200));
    }
    viewer.rest();
    let title = session.display.hands(&format!("getwindowname {window}"));
    assert_eq!(title, "cornell.glb * - lumigon");
    std::thread::sleep(Duration::from_secs(2));

    session.display.close();
    let start = Instant::now();
    let output = viewer.end();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(start.elapsed() < Duration::from_secs(20));
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(!said.contains("panicked"), "{said}");

    // The next window offers the edit.
    session.display = crate::display::Display::open();
    let output = session.replay(
        "cornell.glb",
        r#"
        settle
        screenshot offered.png
        click "Take the edits up"
        settle
        screenshot taken-up.png
        key Ctrl+Q
        wait 2
        click "Do not save"
        "#,
    );
    assert!(output.status.success());
}

//! `lumigon view` as a process, in a real window on a display without a screen.

mod display;
mod session;

use session::Session;

#[test]
fn a_window_opens_and_is_saved_as_it_is() {
    let session = Session::with("cornell.glb");
    let words = "view cornell.glb --size 640x400 --frames 3 --screenshot window.png";
    let output = session.start(words).end();
    assert!(output.status.success(), "{output:?}");
    let window = session.image("window.png");
    assert_eq!(window.size(), [640, 400]);
    // Not empty, and not of one colour.
    assert!(window.difference(&window.part(0, 0, [640, 400])) == 0);
    assert!(window.mean() > 10.0);
}

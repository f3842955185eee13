//! Turning the camera, taking hold of a light: what is done is on screen at once, and can be taken back.

use crate::session::Session;

/// The Cornell box's lamp in a window of 900 x 600 points, and what of the box its light changes.
const LAMP: &str = "460 163";
const FLOOR: (u32, u32, [u32; 2]) = (300, 440, [140, 38]);

/// The colour of an outline that is refused.
const RED: [u8; 3] = [255, 70, 60];

#[test]
fn the_first_view_comes_back() {
    let session = Session::with("cornell.glb");
    session.replay(
        "cornell.glb",
        r#"
        settle
        picture first.png
        drag "Picture" 60 20
        settle
        picture turned.png
        wheel 400 300 3
        drag 400 300 10 40 middle
        key Shift+Home
        settle
        picture back.png
        screenshot window.png
        "#,
    );
    let first = session.image("first.png");
    assert_eq!(session.image("window.png").size(), [900, 600]);
    assert_eq!(first.size(), [380, 550]);
    assert!(session.image("turned.png").difference(&first) > 100);
    assert_eq!(session.image("back.png"), first);
}

#[test]
fn lights_are_reshaped_and_restored() {
    let session = Session::with("cornell.glb");
    session.replay(
        "cornell.glb",
        &format!(
            r#"
            settle
            picture start.png
            click {LAMP}
            settle
            picture selected.png
            point "Vertex 1"
            press left
            point 540 130
            point 560 110
            release left
            settle
            picture dragged.png
            key Ctrl+Z
            settle
            picture undone.png
            key Ctrl+Shift+Z
            settle
            picture redone.png
            key Ctrl+Z
            wait 1

            point 460 171
            key I
            wait 2
            drag "Vertex 4" 0 12
            settle
            screenshot five.png
            picture five-picture.png

            point "Vertex 3"
            press left
            point 465 130
            screenshot crossing.png
            release left
            settle
            picture still-five.png

            double-click 460 157
            settle
            drag "Vertex 2" 0 -20
            settle
            screenshot six.png
            picture six-picture.png
            click "Delete"
            settle
            screenshot deleted.png
            picture deleted-picture.png
            "#
        ),
    );
    let start = session.image("start.png");
    let dragged = session.image("dragged.png");
    // Handles lie over the picture, they are not in it.
    assert_eq!(session.image("selected.png"), start);
    assert!(dragged.mean() > start.mean() * 1.2, "{dragged:?} {start:?}");
    assert_eq!(session.image("undone.png"), start);
    assert_eq!(session.image("redone.png"), dragged);

    let five = session.image("five-picture.png");
    assert!(five.difference(&start) > 5);
    assert_eq!(session.image("five.png").count(RED), 0);
    // The outline crosses itself, and the light is what it was.
    assert!(session.image("crossing.png").count(RED) > 40);
    assert_eq!(session.image("still-five.png"), five);

    let six = session.image("six-picture.png");
    assert!(six.difference(&five) > 5);
    assert_eq!(session.image("deleted-picture.png"), five);
}

#[test]
fn a_drag_is_on_screen_in_the_frame_that_gets_it() {
    let session = Session::with("cornell.glb");
    let script = format!(
        "wait 60\n click {LAMP}\n wait 2\n point 493 157\n press left\n screenshot before.png\n point 560 110\n wait 9"
    );
    std::fs::write(session.path("input.txt"), script).unwrap();
    // Frames of the waits, the click, and the others up to the drag.
    let frames = 61 + 3 + 3 + 1 + 1 + 1 + 1;
    let words = format!(
        "view cornell.glb --size 900x600 --backend cpu --replay input.txt --frames {frames} --screenshot after.png"
    );
    let output = session.start(&words).end();
    assert!(output.status.success(), "{output:?}");
    let (x, y, size) = FLOOR;
    let [before, after] =
        ["before.png", "after.png"].map(|name| session.image(name).part(x, y, size));
    assert!(before.mean() > 10.0);
    assert!(after.mean() > before.mean() * 1.1, "{before:?} {after:?}");
}

#[test]
fn images_shine_from_lights_and_broken_ones_do_no_harm() {
    let session = Session::with("cornell.glb");
    let colors = image::RgbImage::from_fn(32, 32, |x, _| {
        image::Rgb(if x < 16 { [255, 0, 0] } else { [0, 0, 255] })
    });
    colors.save(session.path("colours.png")).unwrap();
    let whole = std::fs::read(session.path("colours.png")).unwrap();
    std::fs::write(session.path("broken.png"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(session.path("words.txt"), "no image").unwrap();
    session.replay(
        "cornell.glb",
        &format!(
            r#"
            settle
            picture start.png
            point 330 560
            drop "colours.png"
            settle
            screenshot nothing-there.png
            key Escape
            point {LAMP}
            drop "broken.png"
            settle
            screenshot broken.png.png
            drop "words.txt"
            drop "missing.png"
            settle
            screenshot more.png
            picture unharmed.png
            drop "colours.png"
            settle
            screenshot image.png
            picture shining.png
            click "Remove"
            settle
            picture removed.png
            key Ctrl+Z
            key Ctrl+Z
            settle
            picture undone.png
            "#
        ),
    );
    let start = session.image("start.png");
    assert_eq!(session.image("unharmed.png"), start);
    assert!(session.image("shining.png").difference(&start) > 50);
    assert_eq!(session.image("undone.png"), start);
    // What is wrong stands over the picture.
    for name in ["nothing-there.png", "broken.png.png", "more.png"] {
        assert!(session.image(name).count([255, 140, 130]) > 100, "{name}");
    }
}

//! Two sides with methods of their own, and the methods against the truth.

use crate::session::Session;

/// The lit floor in front of the light, left and right of the middle.
const LEFT: (u32, u32, [u32; 2]) = (420, 330, [30, 80]);
const RIGHT: (u32, u32, [u32; 2]) = (470, 330, [30, 80]);

#[test]
fn sides_show_methods_of_their_own() {
    let session = Session::with("check/square.glb");
    session.replay(
        "square.glb",
        r#"
        settle
        screenshot whole-window.png
        picture whole.png
        click "LTC, one lobe"
        wait 2
        click "none"
        settle
        picture no-specular.png
        key S
        settle
        screenshot split.png
        drag "Divider" 80 0
        settle
        screenshot divided.png
        key X
        settle
        screenshot swapped.png
        click "Split view"
        settle
        screenshot one-window.png
        picture one.png
        "#,
    );
    let part =
        |name: &str, (x, y, size): (u32, u32, [u32; 2])| session.image(name).part(x, y, size);
    let whole = session.image("whole.png");
    assert!(session.image("no-specular.png").difference(&whole) > 20);
    assert_eq!(session.image("one.png"), whole);
    // The reflection is on the right side alone.
    let [left, right] = [LEFT, RIGHT].map(|place| part("split.png", place));
    assert!(right.mean() > left.mean() * 1.5, "{left:?} {right:?}");
    assert_eq!(right, part("whole-window.png", RIGHT));
    // The divider has gone to the right, then the sides change places.
    assert_eq!(part("divided.png", LEFT), left);
    assert!(part("divided.png", RIGHT).mean() < right.mean() / 1.5);
    assert_eq!(part("swapped.png", RIGHT), right);
}

#[test]
fn the_truth_converges_and_shows_what_is_wrong() {
    let session = Session::with("cornell.glb");
    session.replay(
        "cornell.glb",
        r#"
        resize 640 360
        settle
        screenshot picture.png
        key E
        settle
        screenshot error.png
        key W
        settle
        screenshot reference.png
        key N
        settle
        screenshot noise.png
        key L
        settle
        screenshot counts.png
        key Q
        settle
        screenshot picture-again.png
        "#,
    );
    let names = [
        "picture",
        "error",
        "reference",
        "noise",
        "counts",
        "picture-again",
    ];
    let images = names.map(|name| session.image(&format!("{name}.png")));
    let [picture, error, reference, noise, counts, again] = &images;
    assert_eq!(picture.size(), [640, 360]);
    assert_eq!(again, picture);
    // The box in the window, without the label above and the legend below.
    let inside = |image: &crate::session::Image| image.part(274, 120, [112, 115]);
    let [picture, error, reference, noise, counts] =
        [picture, error, reference, noise, counts].map(inside);
    // Diffuse surfaces are exact: the reference is the picture but for its noise, and the error is next to
    // nothing, which is light grey.
    assert!(
        (reference.mean() / picture.mean() - 1.0).abs() < 0.02,
        "{reference:?} {picture:?}"
    );
    assert!(error.mean() > 200.0, "{error:?}");
    for (a, b) in [
        (&noise, &picture),
        (&noise, &error),
        (&counts, &noise),
        (&counts, &error),
    ] {
        assert!(a.difference(b) > 100);
    }
    // How far the reference has come stands in the last line.
    let status = |image: &crate::session::Image| image.part(230, 340, [400, 18]);
    let [plain, with_progress] = [&images[0], &images[1]].map(status);
    assert!(with_progress.mean() > plain.mean() * 1.5);
}

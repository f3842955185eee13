//! What is saved is what was on screen.

use crate::session::Session;

#[test]
fn saved_scenes_come_back_as_they_were() {
    let session = Session::with("cornell.glb");
    session.replay(
        "cornell.glb",
        r#"
        settle
        picture untouched.png
        click 460 163
        settle
        drag "Vertex 1" 60 -40
        key H
        settle
        key Ctrl+Shift+S
        wait 2
        key Ctrl+A
        text "saved.glb"
        wait 2
        screenshot dialog.png
        click "Save here"
        settle
        screenshot saved.png
        point "Saved saved.glb"
        picture before.png
        "#,
    );
    assert!(
        session
            .image("before.png")
            .difference(&session.image("untouched.png"))
            > 50
    );
    session.replay(
        "saved.glb",
        "settle\n picture after.png\n screenshot reopened.png\n",
    );
    // Coordinates are rounded to the file's 32 bits.
    let before = session.image("before.png");
    let difference = session.image("after.png").difference(&before);
    assert!(difference <= 1, "{difference}");

    let words = "render saved.glb --size 380x550 --samples 16 -o rendered.png";
    let output = session.start(words).end();
    assert!(output.status.success(), "{output:?}");
    let difference = session.image("rendered.png").difference(&before);
    assert!(difference <= 1, "{difference}");
}

#[test]
fn what_cannot_be_saved_is_told_and_kept() {
    let session = Session::with("cornell.glb");
    // A file where a folder should be: not even root can write into it.
    std::fs::write(session.path("no-folder"), "").unwrap();
    session.replay(
        "cornell.glb",
        r#"
        settle
        click 460 163
        settle
        drag "Vertex 1" 60 -40
        settle
        picture edited.png
        key Ctrl+Shift+S
        wait 2
        key Ctrl+A
        text "no-folder/saved.glb"
        wait 2
        key Enter
        settle
        screenshot refused.png
        picture still-edited.png
        key Ctrl+Q
        wait 2
        screenshot asked.png
        click "Stay"
        settle
        key Ctrl+Z
        settle
        picture undone.png
        key Ctrl+Q
        "#,
    );
    assert!(session.image("refused.png").count([255, 140, 130]) > 100);
    let edited = session.image("edited.png");
    assert_eq!(session.image("still-edited.png"), edited);
    assert!(session.image("undone.png").difference(&edited) > 50);
    assert_eq!(std::fs::read(session.path("no-folder")).unwrap(), b"");
}

//! What can be asked of the window: each command has a name, a key, and plain words.

use egui::{Key, KeyboardShortcut, Modifiers};

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Command {
    Open,
    Save,
    SaveAs,
    SavePicture,
    Undo,
    Redo,
    FrameAll,
    FrameLight,
    NextCamera,
    FirstView,
    Shape,
    Move,
    Turn,
    Scale,
    InsertVertex,
    AddHole,
    Delete,
    Duplicate,
    TwoSided,
    AddRectangle,
    AddDisk,
    AddStar,
    AddLetter,
    AddRing,
    Split,
    ShowPicture,
    ShowReference,
    ShowError,
    ShowNoise,
    ShowLightCounts,
    SwapSides,
    Brighter,
    Darker,
    NextToneMap,
    Probe,
    Timings,
    Panels,
    Help,
    Deselect,
    Quit,
}

/// Of the menu that a command stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group {
    File,
    Edit,
    View,
    Light,
    Compare,
}

impl Group {
    pub(crate) const ALL: [Self; 5] = [
        Self::File,
        Self::Edit,
        Self::View,
        Self::Light,
        Self::Compare,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::View => "View",
            Self::Light => "Light",
            Self::Compare => "Compare",
        }
    }
}

/// A command as menus and the list of keys show it.
pub(crate) struct Entry {
    pub(crate) command: Command,
    pub(crate) group: Group,
    pub(crate) name: &'static str,
    pub(crate) shortcut: KeyboardShortcut,
    pub(crate) help: &'static str,
}

const fn entry(
    command: Command,
    group: Group,
    name: &'static str,
    modifiers: Modifiers,
    key: Key,
    help: &'static str,
) -> Entry {
    Entry {
        command,
        group,
        name,
        shortcut: KeyboardShortcut::new(modifiers, key),
        help,
    }
}

const NONE: Modifiers = Modifiers::NONE;
const COMMAND: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const COMMAND_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// All of them. Where one key is part of another's, the longer chord comes first.
#[rustfmt::skip]
pub(crate) const COMMANDS: [Entry; 40] = [
    entry(Command::Open, Group::File, "Open...", COMMAND, Key::O, "Open another glTF scene"),
    entry(Command::SaveAs, Group::File, "Save as...", COMMAND_SHIFT, Key::S, "Save the scene with its lights as glTF, in a new place"),
    entry(Command::Save, Group::File, "Save", COMMAND, Key::S, "Save the scene with its lights as glTF"),
    entry(Command::SavePicture, Group::File, "Save picture...", NONE, Key::F12, "Save the picture without panels: PNG as it is shown, EXR as linear radiance"),
    entry(Command::Quit, Group::File, "Quit", COMMAND, Key::Q, "Close the window"),
    entry(Command::Redo, Group::Edit, "Redo", COMMAND_SHIFT, Key::Z, "Do again what was undone"),
    entry(Command::Undo, Group::Edit, "Undo", COMMAND, Key::Z, "Take the last change back"),
    entry(Command::Duplicate, Group::Edit, "Duplicate light", COMMAND, Key::D, "A second light like the selected one, beside it"),
    entry(Command::Delete, Group::Edit, "Delete", NONE, Key::Delete, "Delete the selected vertex, or else the selected light"),
    entry(Command::Deselect, Group::Edit, "Let go", NONE, Key::Escape, "Give up what is being dragged, close what is open, select nothing"),
    entry(Command::FirstView, Group::View, "First view", SHIFT, Key::Home, "Back to where the window opened"),
    entry(Command::FrameAll, Group::View, "Show all", NONE, Key::Home, "Move back until the whole scene is in view"),
    entry(Command::FrameLight, Group::View, "Show the light", NONE, Key::F, "Move to the selected light"),
    entry(Command::NextCamera, Group::View, "Next camera", NONE, Key::C, "Look through the file's next camera"),
    entry(Command::Brighter, Group::View, "Brighter", NONE, Key::CloseBracket, "A third of a stop more exposure"),
    entry(Command::Darker, Group::View, "Darker", NONE, Key::OpenBracket, "A third of a stop less exposure"),
    entry(Command::NextToneMap, Group::View, "Next tone map", NONE, Key::T, "How radiance becomes what the display can show"),
    entry(Command::Panels, Group::View, "Panels", NONE, Key::F4, "Show or hide the panels"),
    entry(Command::Timings, Group::View, "Frame times", NONE, Key::G, "A graph of what each part of a frame takes"),
    entry(Command::Help, Group::View, "Keys", NONE, Key::F1, "This list"),
    entry(Command::Shape, Group::Light, "Shape", NONE, Key::V, "Drag the selected light's vertices in its plane"),
    entry(Command::Move, Group::Light, "Move", NONE, Key::M, "Drag the selected light along arrows"),
    entry(Command::Turn, Group::Light, "Turn", NONE, Key::R, "Turn the selected light with rings"),
    entry(Command::Scale, Group::Light, "Scale", NONE, Key::K, "Drag the selected light's width and height"),
    entry(Command::InsertVertex, Group::Light, "Insert vertex", NONE, Key::I, "A new vertex on the edge nearest to the pointer; double-click on an edge does the same"),
    entry(Command::AddHole, Group::Light, "Cut a hole", NONE, Key::H, "A hole where the pointer is on the light, or in its middle"),
    entry(Command::TwoSided, Group::Light, "Two-sided", NONE, Key::B, "Whether the light emits from its back too"),
    entry(Command::AddRectangle, Group::Light, "New rectangle", NONE, Key::Num1, "A rectangular light in front of the camera"),
    entry(Command::AddDisk, Group::Light, "New disk", NONE, Key::Num2, "A round light in front of the camera"),
    entry(Command::AddStar, Group::Light, "New star", NONE, Key::Num3, "A star of five points in front of the camera"),
    entry(Command::AddLetter, Group::Light, "New letter", NONE, Key::Num4, "A letter in front of the camera; which one is chosen beside it"),
    entry(Command::AddRing, Group::Light, "New ring", NONE, Key::Num5, "A ring in front of the camera"),
    entry(Command::Split, Group::Compare, "Split view", NONE, Key::S, "Two sides with methods of their own, and a divider to drag"),
    entry(Command::SwapSides, Group::Compare, "Swap sides", NONE, Key::X, "What the left side shows goes right, and the other way round"),
    entry(Command::ShowPicture, Group::Compare, "Picture", NONE, Key::Q, "The scene, lit by the chosen methods"),
    entry(Command::ShowReference, Group::Compare, "Reference", NONE, Key::W, "The path-traced truth, converging while nothing moves"),
    entry(Command::ShowError, Group::Compare, "Error", NONE, Key::E, "The methods against the truth: red where too bright, blue where too dark"),
    entry(Command::ShowNoise, Group::Compare, "Noise", NONE, Key::N, "What the truth may still be off by"),
    entry(Command::ShowLightCounts, Group::Compare, "Lights per pixel", NONE, Key::L, "How many lights each pixel computes, as a heat map"),
    entry(Command::Probe, Group::Compare, "Probe", NONE, Key::P, "What arrives at the surface under the pointer, by every method"),
];

impl Command {
    pub(crate) fn entry(self) -> &'static Entry {
        let found = COMMANDS.iter().find(|entry| entry.command == self);
        // Each is in the list: a test sees to it.
        found.unwrap_or(&COMMANDS[0])
    }
}

/// The commands whose keys were pressed in this frame.
pub(crate) fn pressed(context: &egui::Context) -> Vec<Command> {
    context.input_mut(|input| {
        let mut pressed = Vec::new();
        for entry in &COMMANDS {
            if input.consume_shortcut(&entry.shortcut) {
                pressed.push(entry.command);
            }
        }
        pressed
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_key_of_its_own_and_words() {
        for (i, a) in COMMANDS.iter().enumerate() {
            assert!(!a.name.is_empty() && !a.help.is_empty());
            assert_eq!(a.command.entry().name, a.name);
            for b in &COMMANDS[..i] {
                assert_ne!(a.shortcut, b.shortcut, "{} and {}", a.name, b.name);
                assert_ne!(a.command, b.command);
            }
        }
    }

    #[test]
    fn every_key_runs_its_own_command() {
        let context = egui::Context::default();
        for entry in &COMMANDS {
            let KeyboardShortcut {
                modifiers,
                logical_key,
            } = entry.shortcut;
            let input = egui::RawInput {
                events: vec![
                    egui::Event::ModifiersChanged(modifiers),
                    egui::Event::Key {
                        key: logical_key,
                        physical_key: None,
                        pressed: true,
                        repeat: false,
                        modifiers,
                    },
                ],
                ..Default::default()
            };
            let mut got = Vec::new();
            let mut output = context.run_ui(input, |ui| got.extend(pressed(ui.ctx())));
            // No window takes them.
            output.textures_delta.clear();
            assert_eq!(got, [entry.command], "{}", entry.name);
        }
    }
}

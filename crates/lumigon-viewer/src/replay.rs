//! Recorded input: a line an action, read as it is written.
//!
//! ```text
//! # From a script. Places are points from the upper left, sizes too.
//! resize 1280 800
//! settle                    until nothing moves and nothing works in the background
//! click "Split view"        on what carries that name
//! drag "Vertex 2" 40 -20    from there, by as much
//! drag 300 200 40 0         from a place
//! point 300 200             moves the pointer
//! press left                left, middle or right; `release left` lets go
//! wheel 300 200 -3          lines
//! hold Shift                until `let Shift`
//! key Ctrl+Z                down and up
//! text "lamp.glb"
//! drop picture.png          a file, onto the window, where the pointer is
//! wait 10                   frames
//! screenshot a.png          the window; `picture a.exr` the picture alone
//! lose-device               the GPU is gone, as drivers lose it
//! ```
//!
//! Each action has at least a frame of its own, and each frame the same length: what is replayed does
//! not depend on how fast the machine is.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use lumigon_renderer::write_whole;

use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2};

/// Seconds of a frame that is replayed.
pub(crate) const FRAME: f64 = 1.0 / 60.0;

/// Frames of a drag between its ends.
const STEPS: u16 = 6;

/// Frames that `settle` and a name wait for at most, before they give up.
const PATIENCE: u32 = 3600;

/// Where an action happens.
#[derive(Clone, Debug, PartialEq)]
enum Place {
    At(Pos2),
    /// The middle of what carries a name.
    Named(String),
}

#[derive(Clone, Debug, PartialEq)]
enum Action {
    Resize(Vec2),
    Settle,
    Point(Place),
    Press(PointerButton),
    Release(PointerButton),
    Click(Place, PointerButton, u8),
    Drag(Place, Vec2, PointerButton),
    Wheel(Place, f32),
    Hold(Modifiers),
    Let(Modifiers),
    Key(Modifiers, Key),
    Text(String),
    Drop(PathBuf),
    Wait(u32),
    Screenshot(PathBuf),
    Picture(PathBuf),
    LoseDevice,
}

/// What a frame is to do besides the events that egui gets.
#[derive(Debug, PartialEq)]
pub(crate) enum Demand {
    Resize(Vec2),
    Drop(PathBuf),
    Screenshot(PathBuf),
    Picture(PathBuf),
    LoseDevice,
}

/// Why recorded input stops.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file cannot be read.
    #[error("{path}: {source}: give a file of recorded input", path = path.display())]
    Unreadable {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A line is no action.
    #[error("{path}, line {line}: {what}", path = path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong, and what may stand there.
        what: String,
    },
}

/// Recorded input on its way into the window.
#[derive(Debug)]
pub(crate) struct Replay {
    path: PathBuf,
    actions: VecDeque<(usize, Action)>,
    /// Frames of events that the current action still has.
    frames: VecDeque<Vec<Event>>,
    waited: u32,
    pointer: Pos2,
    modifiers: Modifiers,
}

/// What the window knows of itself when a frame begins.
pub(crate) struct Standing<'a> {
    /// Nothing moves and nothing works in the background.
    pub(crate) is_settled: bool,
    /// Where something of that name is.
    pub(crate) find: &'a dyn Fn(&str) -> Option<Pos2>,
}

impl Replay {
    pub(crate) fn read(path: &Path) -> Result<Self, ReplayError> {
        let text = std::fs::read_to_string(path).map_err(|source| ReplayError::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, path)
    }

    fn parse(text: &str, path: &Path) -> Result<Self, ReplayError> {
        let mut actions = VecDeque::new();
        for (index, line) in text.lines().enumerate() {
            let fault = |what| ReplayError::Line {
                path: path.to_owned(),
                line: index + 1,
                what,
            };
            let words = words(line).map_err(fault)?;
            if !words.is_empty() {
                actions.push_back((index + 1, action(&words).map_err(fault)?));
            }
        }
        Ok(Self {
            path: path.to_owned(),
            actions,
            frames: VecDeque::new(),
            waited: 0,
            pointer: Pos2::ZERO,
            modifiers: Modifiers::NONE,
        })
    }

    pub(crate) fn is_over(&self) -> bool {
        self.actions.is_empty() && self.frames.is_empty()
    }

    /// Whether it waits for what goes on in the background.
    pub(crate) fn is_waiting(&self) -> bool {
        self.frames.is_empty() && matches!(self.actions.front(), Some((_, Action::Settle)))
    }

    /// The events of the next frame, and what else it is to do.
    pub(crate) fn frame(
        &mut self,
        standing: &Standing<'_>,
    ) -> Result<(Vec<Event>, Option<Demand>), ReplayError> {
        if let Some(events) = self.frames.pop_front() {
            return Ok((events, None));
        }
        let Some((line, action)) = self.actions.front().cloned() else {
            return Ok((Vec::new(), None));
        };
        let mut demand = None;
        let is_done = match action {
            Action::Resize(size) => {
                demand = Some(Demand::Resize(size));
                true
            }
            Action::Settle => standing.is_settled && self.waited > 1,
            Action::Wait(frames) => self.waited >= frames,
            Action::Point(place) => self.at(&place, standing, Self::go),
            Action::Press(button) => {
                self.button(button, true);
                true
            }
            Action::Release(button) => {
                self.button(button, false);
                true
            }
            Action::Click(place, button, times) => self.at(&place, standing, |this, at| {
                this.go(at);
                for _ in 0..times {
                    this.button(button, true);
                    this.button(button, false);
                }
            }),
            Action::Drag(place, by, button) => self.at(&place, standing, |this, at| {
                this.go(at);
                this.button(button, true);
                for step in 1..=STEPS {
                    this.go(at + by * (f32::from(step) / f32::from(STEPS)));
                }
                this.button(button, false);
            }),
            Action::Wheel(place, lines) => self.at(&place, standing, |this, at| {
                this.go(at);
                let modifiers = this.modifiers;
                this.frames.push_back(vec![Event::MouseWheel {
                    unit: egui::MouseWheelUnit::Line,
                    delta: Vec2::new(0.0, lines),
                    phase: egui::TouchPhase::Move,
                    source: egui::MouseWheelSource::Unknown,
                    modifiers,
                }]);
            }),
            Action::Hold(modifiers) => {
                self.modifiers |= modifiers;
                self.tell_modifiers(self.modifiers);
                true
            }
            Action::Let(modifiers) => {
                let held = &mut self.modifiers;
                held.shift &= !modifiers.shift;
                held.alt &= !modifiers.alt;
                held.ctrl &= !modifiers.ctrl;
                held.command &= !modifiers.command;
                self.tell_modifiers(self.modifiers);
                true
            }
            Action::Key(modifiers, key) => {
                let modifiers = modifiers | self.modifiers;
                self.tell_modifiers(modifiers);
                for pressed in [true, false] {
                    self.frames.push_back(vec![Event::Key {
                        key,
                        physical_key: None,
                        pressed,
                        repeat: false,
                        modifiers,
                    }]);
                }
                self.tell_modifiers(self.modifiers);
                true
            }
            Action::Text(text) => {
                self.frames.push_back(vec![Event::Text(text)]);
                true
            }
            Action::Drop(path) => {
                demand = Some(Demand::Drop(path));
                true
            }
            Action::Screenshot(path) => {
                demand = Some(Demand::Screenshot(path));
                true
            }
            Action::Picture(path) => {
                demand = Some(Demand::Picture(path));
                true
            }
            Action::LoseDevice => {
                demand = Some(Demand::LoseDevice);
                true
            }
        };
        if is_done {
            self.actions.pop_front();
            self.waited = 0;
        } else {
            self.waited += 1;
            if self.waited > PATIENCE {
                return Err(ReplayError::Line {
                    path: self.path.clone(),
                    line,
                    what: format!(
                        "in {PATIENCE} frames it did not come to that: is the name on screen?"
                    ),
                });
            }
        }
        let events = self.frames.pop_front().unwrap_or_default();
        Ok((events, demand))
    }

    /// Does what is to be done at a place, once that is there.
    fn at(
        &mut self,
        place: &Place,
        standing: &Standing<'_>,
        act: impl FnOnce(&mut Self, Pos2),
    ) -> bool {
        let found = match place {
            Place::At(at) => Some(*at),
            Place::Named(name) => (standing.find)(name),
        };
        found.map(|at| act(self, at)).is_some()
    }

    fn tell_modifiers(&mut self, modifiers: Modifiers) {
        self.frames
            .push_back(vec![Event::ModifiersChanged(modifiers)]);
    }

    fn go(&mut self, to: Pos2) {
        self.pointer = to;
        self.frames.push_back(vec![Event::PointerMoved(to)]);
    }

    fn button(&mut self, button: PointerButton, pressed: bool) {
        self.frames.push_back(vec![Event::PointerButton {
            pos: self.pointer,
            button,
            pressed,
            modifiers: self.modifiers,
        }]);
    }
}

/// The words of a line; those in quotes are one, and begin with a quote.
fn words(line: &str) -> Result<Vec<String>, String> {
    let mut words = Vec::new();
    let mut rest = line.trim_start();
    while !rest.is_empty() && !rest.starts_with('#') {
        let length = if let Some(inner) = rest.strip_prefix('"') {
            let end = inner.find('"').ok_or("close the quotes")?;
            end + 2
        } else {
            rest.find(char::is_whitespace).unwrap_or(rest.len())
        };
        words.push(rest[..length].trim_end_matches('"').to_owned());
        rest = rest[length..].trim_start();
    }
    Ok(words)
}

fn action(words: &[String]) -> Result<Action, String> {
    let (verb, arguments) = words.split_first().ok_or("write an action")?;
    let number = |index: usize| -> Result<f32, String> {
        let word = arguments.get(index).ok_or("a number is missing")?;
        let number: f32 = word
            .parse()
            .map_err(|_| format!("{word} is not a number"))?;
        // Far beyond any screen, and yet sums of them are numbers.
        (number.abs() <= 1e6)
            .then_some(number)
            .ok_or_else(|| format!("{word} is out of range"))
    };
    let word = |index: usize| -> Result<&str, String> {
        let word = arguments.get(index).map(|word| word.trim_matches('"'));
        word.ok_or_else(|| format!("{verb} needs one word more"))
    };
    // A place, and how many words it takes.
    let place = || -> Result<(Place, usize), String> {
        match arguments.first() {
            Some(name) if name.starts_with('"') => Ok((Place::Named(name[1..].to_owned()), 1)),
            _ => Ok((Place::At(Pos2::new(number(0)?, number(1)?)), 2)),
        }
    };
    let button = |index: usize, or: PointerButton| match arguments.get(index).map(String::as_str) {
        None => Ok(or),
        Some("left") => Ok(PointerButton::Primary),
        Some("middle") => Ok(PointerButton::Middle),
        Some("right") => Ok(PointerButton::Secondary),
        Some(other) => Err(format!("{other} is no button: use left, middle or right")),
    };
    let left = PointerButton::Primary;
    let count = |index: usize| -> Result<u32, String> {
        let word = arguments.get(index).ok_or("a number is missing")?;
        word.parse()
            .map_err(|_| format!("{word} is not a number of frames"))
    };
    let (action, used) = match verb.as_str() {
        "resize" => {
            let size = Vec2::new(number(0)?, number(1)?);
            if size.min_elem() < 1.0 {
                return Err("a window has at least one point each way".to_owned());
            }
            (Action::Resize(size), 2)
        }
        "settle" => (Action::Settle, 0),
        "wait" => (Action::Wait(count(0)?), 1),
        "point" => {
            let (place, used) = place()?;
            (Action::Point(place), used)
        }
        "press" => (Action::Press(button(0, left)?), 1),
        "release" => (Action::Release(button(0, left)?), 1),
        "click" | "double-click" => {
            let (place, used) = place()?;
            let times = if verb == "click" { 1 } else { 2 };
            let button = button(used, left)?;
            (Action::Click(place, button, times), used + 1)
        }
        "drag" => {
            let (place, used) = place()?;
            let by = Vec2::new(number(used)?, number(used + 1)?);
            let button = button(used + 2, left)?;
            (Action::Drag(place, by, button), used + 3)
        }
        "wheel" => {
            let (place, used) = place()?;
            (Action::Wheel(place, number(used)?), used + 1)
        }
        "hold" => (Action::Hold(modifier(word(0)?)?), 1),
        "let" => (Action::Let(modifier(word(0)?)?), 1),
        "key" => {
            let (modifiers, key) = chord(word(0)?)?;
            (Action::Key(modifiers, key), 1)
        }
        "text" => (Action::Text(word(0)?.to_owned()), 1),
        "drop" => (Action::Drop(word(0)?.into()), 1),
        "screenshot" => (Action::Screenshot(word(0)?.into()), 1),
        "picture" => (Action::Picture(word(0)?.into()), 1),
        "lose-device" => (Action::LoseDevice, 0),
        other => {
            return Err(format!(
                "{other} is no action: use click, double-click, drag, point, press, release, wheel, \
                 hold, let, key, text, drop, resize, wait, settle, screenshot or picture"
            ));
        }
    };
    match arguments.get(used) {
        Some(more) => Err(format!("{more} is one word too many")),
        None => Ok(action),
    }
}

fn modifier(name: &str) -> Result<Modifiers, String> {
    match name {
        "Shift" => Ok(Modifiers::SHIFT),
        "Alt" => Ok(Modifiers::ALT),
        "Ctrl" => Ok(Modifiers::CTRL | Modifiers::COMMAND),
        other => Err(format!("{other} is no modifier: use Shift, Alt or Ctrl")),
    }
}

/// Such as Ctrl+Shift+Z.
fn chord(text: &str) -> Result<(Modifiers, Key), String> {
    let mut modifiers = Modifiers::NONE;
    let mut rest = text;
    while let Some((name, more)) = rest.split_once('+').filter(|(_, more)| !more.is_empty()) {
        modifiers |= modifier(name)?;
        rest = more;
    }
    let key = Key::from_name(rest).ok_or_else(|| format!("{rest} is no key"))?;
    Ok((modifiers, key))
}

/// Input on its way to a file.
#[derive(Debug, Default)]
pub(crate) struct Recording {
    text: String,
    /// Frames without input since the last line.
    quiet: u32,
    pointer: Pos2,
    modifiers: Modifiers,
}

impl Recording {
    /// Takes down what a frame got.
    pub(crate) fn frame(&mut self, events: &[Event], dropped: &[PathBuf]) {
        let before = self.text.len();
        let mut lines = String::new();
        for event in events {
            match event {
                Event::ModifiersChanged(modifiers) => {
                    for (name, held, was) in [
                        ("Shift", modifiers.shift, self.modifiers.shift),
                        ("Alt", modifiers.alt, self.modifiers.alt),
                        ("Ctrl", modifiers.ctrl, self.modifiers.ctrl),
                    ] {
                        if held != was {
                            let verb = if held { "hold" } else { "let" };
                            _ = writeln!(lines, "{verb} {name}");
                        }
                    }
                    self.modifiers = *modifiers;
                }
                Event::PointerMoved(at) => {
                    self.pointer = *at;
                    _ = writeln!(lines, "point {:.1} {:.1}", at.x, at.y);
                }
                Event::PointerButton {
                    button, pressed, ..
                } => {
                    let verb = if *pressed { "press" } else { "release" };
                    let name = match button {
                        PointerButton::Primary => "left",
                        PointerButton::Middle => "middle",
                        PointerButton::Secondary => "right",
                        _ => continue,
                    };
                    _ = writeln!(lines, "{verb} {name}");
                }
                Event::MouseWheel { unit, delta, .. } => {
                    let lines_of = match unit {
                        egui::MouseWheelUnit::Point => delta.y / 40.0,
                        egui::MouseWheelUnit::Line => delta.y,
                        egui::MouseWheelUnit::Page => delta.y * 10.0,
                    };
                    let Pos2 { x, y } = self.pointer;
                    _ = writeln!(lines, "wheel {x:.1} {y:.1} {lines_of}");
                }
                Event::Key {
                    key, pressed: true, ..
                } => _ = writeln!(lines, "key {}", key.name()),
                Event::Text(text) if !text.contains(['"', '\n']) => {
                    _ = writeln!(lines, "text \"{text}\"");
                }
                _ => {}
            }
        }
        for path in dropped {
            _ = writeln!(lines, "drop \"{}\"", path.display());
        }
        if lines.is_empty() {
            self.quiet += 1;
            return;
        }
        if self.quiet > 0 && before > 0 {
            _ = writeln!(self.text, "wait {}", self.quiet);
        }
        self.quiet = 0;
        self.text.push_str(&lines);
    }

    /// Writes it, whole or not at all.
    pub(crate) fn save(&self, path: &Path) -> std::io::Result<()> {
        write_whole(path, |file| file.write_all(self.text.as_bytes()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn events(text: &str) -> Vec<Event> {
        let mut replay = Replay::parse(text, Path::new("test")).unwrap();
        let standing = Standing {
            is_settled: true,
            find: &|name| (name == "there").then_some(Pos2::new(10.0, 20.0)),
        };
        let mut all = Vec::new();
        while !replay.is_over() {
            all.extend(replay.frame(&standing).unwrap().0);
        }
        all
    }

    #[test]
    fn a_drag_goes_from_what_is_named_by_what_is_said() {
        let all = events("# moves it\ndrag \"there\" 30 -6\n");
        assert_eq!(
            all.first(),
            Some(&Event::PointerMoved(Pos2::new(10.0, 20.0)))
        );
        let last = all.iter().rev().find_map(|event| match event {
            Event::PointerMoved(at) => Some(*at),
            _ => None,
        });
        assert_eq!(last, Some(Pos2::new(40.0, 14.0)));
        let pressed = |down: bool| {
            let of =
                |e: &&Event| matches!(e, Event::PointerButton { pressed, .. } if *pressed == down);
            all.iter().filter(of).count()
        };
        assert_eq!((pressed(true), pressed(false)), (1, 1));
    }

    #[test]
    fn what_is_recorded_replays() {
        let mut recording = Recording::default();
        let shift = Modifiers::SHIFT;
        let button = |pressed| Event::PointerButton {
            pos: Pos2::new(3.0, 4.0),
            button: PointerButton::Primary,
            pressed,
            modifiers: shift,
        };
        recording.frame(&[Event::PointerMoved(Pos2::new(3.0, 4.0))], &[]);
        recording.frame(&[Event::ModifiersChanged(shift), button(true)], &[]);
        recording.frame(&[], &[]);
        recording.frame(&[button(false)], &[]);
        let all = events(&recording.text);
        let expected = [
            Event::PointerMoved(Pos2::new(3.0, 4.0)),
            Event::ModifiersChanged(shift),
            button(true),
            button(false),
        ];
        assert_eq!(all, expected, "{}", recording.text);
    }

    #[test]
    fn faults_name_the_line_and_the_mend() {
        for (text, expected) in [
            ("\ntap 1 2", "line 2: tap is no action"),
            ("click 1", "a number is missing"),
            ("click NaN 1", "out of range"),
            ("click 1 2 thumb", "thumb is no button"),
            ("key Ctrl+Nope", "Nope is no key"),
            ("hold Hyper", "Hyper is no modifier"),
            ("click \"open", "close the quotes"),
            ("settle now", "one word too many"),
            ("resize 0 5", "at least one point"),
            ("wait -1", "not a number of frames"),
        ] {
            let fault = Replay::parse(text, Path::new("test"))
                .unwrap_err()
                .to_string();
            assert!(fault.contains(expected), "{text}: {fault}");
        }
    }

    #[test]
    fn a_name_that_never_comes_is_a_fault() {
        let mut replay = Replay::parse("click \"nowhere\"", Path::new("test")).unwrap();
        let standing = Standing {
            is_settled: true,
            find: &|_| None,
        };
        let fault = (0..=PATIENCE + 1).find_map(|_| replay.frame(&standing).err());
        assert!(fault.unwrap().to_string().contains("line 1"));
    }
}

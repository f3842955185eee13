//! A display without a screen, for as long as a test needs it.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// An X server that draws into memory; it ends with the value, also where a test fails.
pub(crate) struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// A display that nobody else has.
    pub(crate) fn open() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24"])
            .args(["-nolisten", "tcp", "-noreset"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|fault| panic!("Xvfb: {fault}: install the package xvfb"));
        let mut number = String::new();
        let said = BufReader::new(server.stdout.take().unwrap()).read_line(&mut number);
        let display = Self {
            server,
            name: format!(":{}", number.trim()),
        };
        assert!(
            said.is_ok() && number.trim().parse::<u32>().is_ok(),
            "Xvfb gave no display, but {number:?}"
        );
        display
    }

    /// The command on this display. What it remembers for its user goes into `home`.
    pub(crate) fn lumigon(&self, home: &Path) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lumigon"));
        command
            .env("DISPLAY", &self.name)
            .env("HOME", home)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .stdin(Stdio::null());
        for name in [
            "XDG_CACHE_HOME",
            "XDG_CONFIG_HOME",
            "XDG_DATA_HOME",
            "XDG_STATE_HOME",
        ] {
            command.env(name, home.join(name.to_lowercase()));
        }
        command
    }

    /// Does what a user's hands do: the words are xdotool's. What it says.
    pub(crate) fn hands(&self, words: &str) -> String {
        let (succeeds, said) = self.xdotool(words);
        assert!(succeeds, "xdotool {words}: {said}");
        said
    }

    /// What xdotool finds; nothing where there is no such thing.
    pub(crate) fn look(&self, words: &str) -> String {
        match self.xdotool(words) {
            (true, said) => said,
            (false, _) => String::new(),
        }
    }

    fn xdotool(&self, words: &str) -> (bool, String) {
        let output = Command::new("xdotool")
            .args(words.split_whitespace())
            .env("DISPLAY", &self.name)
            .output()
            .unwrap_or_else(|fault| panic!("xdotool: {fault}: install the package xdotool"));
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said).trim().to_owned();
        (output.status.success(), said)
    }

    /// The server ends, as when a user's session does.
    pub(crate) fn close(&mut self) {
        self.server.kill().unwrap();
        self.server.wait().unwrap();
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // It may be gone already.
        _ = self.server.kill();
        _ = self.server.wait();
    }
}

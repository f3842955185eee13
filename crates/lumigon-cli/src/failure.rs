//! Why a command did not do what it was asked, and the exit code that says so.

use std::error::Error;
use std::process::ExitCode;

/// Why a command did not do what it was asked.
#[derive(Debug)]
pub enum Failure {
    /// The arguments contradict each other: exit code 2.
    Usage(clap::Error),
    /// Ctrl-C: exit code 130.
    Interrupted,
    /// Anything else: exit code 1.
    Error(Box<dyn Error + Send + Sync>),
}

impl Failure {
    /// Says on standard error what went wrong, and what to exit with.
    pub fn report(&self) -> ExitCode {
        ExitCode::from(self.report_code())
    }

    pub(crate) fn report_code(&self) -> u8 {
        match self {
            Self::Usage(error) => {
                // Where standard error is closed there is nobody to tell.
                let _ = error.print();
                2
            }
            Self::Interrupted => {
                eprintln!("lumigon: interrupted");
                130
            }
            Self::Error(error) => {
                eprintln!("lumigon: {error}");
                1
            }
        }
    }

    /// Arguments of one subcommand that contradict each other.
    pub(crate) fn usage(subcommand: &str, message: &str) -> Self {
        use clap::CommandFactory;
        let mut command = crate::Arguments::command();
        command.build();
        let error = match command.find_subcommand_mut(subcommand) {
            Some(command) => command.error(clap::error::ErrorKind::ArgumentConflict, message),
            None => command.error(clap::error::ErrorKind::ArgumentConflict, message),
        };
        Self::Usage(error)
    }
}

impl<E: Into<Box<dyn Error + Send + Sync>>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Error(error.into())
    }
}

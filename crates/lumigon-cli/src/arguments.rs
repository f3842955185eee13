//! The command line.

use clap::{Parser, Subcommand};

use crate::{
    Failure, bench, bounce, compare, completions, eval, fit, gpu, images, man, render, scene,
    shaders, view,
};

/// Light from polygons: any planar polygon lights a scene exactly, without noise
#[derive(Debug, Parser)]
#[command(name = "lumigon", version, max_term_width = 100)]
pub struct Arguments {
    /// Threads to compute on [default: one for each logical processor]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// What to do.
    #[command(subcommand)]
    command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
#[allow(missing_docs, reason = "each is documented by its arguments")]
pub enum Command {
    Render(render::Render),
    Compare(compare::Compare),
    View(view::ViewCommand),
    Bounce(bounce::BounceStudy),
    Eval(eval::Eval),
    Scene(scene::SceneCommand),
    Fit(fit::Fit),
    Images(images::Images),
    Shaders(shaders::Shaders),
    Bench(bench::Bench),
    Gpu(gpu::GpuCommand),
    Completions(completions::Completions),
    Man(man::Man),
}

impl Arguments {
    /// Does what the arguments ask for.
    ///
    /// # Errors
    /// Why it could not be done, and with which exit code to say so.
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(threads) = self.threads {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads.into())
                .build_global()?;
        }
        match &self.command {
            Command::Render(command) => command.run(),
            Command::Compare(command) => command.run(),
            Command::View(command) => command.run(),
            Command::Bounce(command) => command.run(),
            Command::Eval(command) => command.run(),
            Command::Scene(command) => command.run(),
            Command::Fit(command) => command.run(),
            Command::Images(command) => command.run(),
            Command::Shaders(command) => command.run(),
            Command::Bench(command) => command.run(),
            Command::Gpu(command) => command.run(),
            Command::Completions(command) => command.run(),
            Command::Man(command) => command.run(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn arguments_are_consistent() {
        Arguments::command().debug_assert();
    }
}

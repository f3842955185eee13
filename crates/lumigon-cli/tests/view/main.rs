//! `lumigon view` as a process, in a real window on a display without a screen.

mod comparing;
mod display;
mod editing;
mod failing;
mod live;
mod saving;
mod session;

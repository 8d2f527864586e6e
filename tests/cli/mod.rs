//! What every command keeps to, its help, and commands with a page of their own.

mod contract;
mod first_minutes;
mod help;
mod plan;
mod report;

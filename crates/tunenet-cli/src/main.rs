//! `tunenet`: system identification for simulators, from the command line.

fn main() -> std::process::ExitCode {
    tunenet_cli::main()
}

//! `tunenet`: makes a simulator behave like a measured real thing.

fn main() -> std::process::ExitCode {
    tunenet_cli::main()
}

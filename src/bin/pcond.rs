//! The program `pcond`: see luxpipe's src/filters/pcond.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Pcond>()
}

//! The program `falsecolor`: see luxpipe's src/filters/falsecolor.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Falsecolor>()
}

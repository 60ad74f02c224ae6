//! The program `pjoin`: see luxpipe's src/filters/pjoin.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Pjoin>()
}

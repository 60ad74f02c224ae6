//! The program `expmerge`: see luxpipe's src/filters/expmerge.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Expmerge>()
}

//! The program `vonkries`: see luxpipe's src/filters/vonkries.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Vonkries>()
}

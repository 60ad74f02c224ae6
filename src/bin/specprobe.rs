//! The program `specprobe`: see luxpipe's src/filters/specprobe.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Specprobe>()
}

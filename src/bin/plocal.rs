//! The program `plocal`: see luxpipe's src/filters/plocal.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Plocal>()
}

//! The program `pplot`: see luxpipe's src/filters/pplot.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Pplot>()
}

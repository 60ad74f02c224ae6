//! Prints the paper's colour figures beside ours as Markdown: `make paper-colour`.

mod colour;

fn main() {
    print!("{}", colour::page());
}

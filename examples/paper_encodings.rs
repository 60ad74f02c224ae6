//! Prints what each encoding of light keeps, and what it costs, as Markdown: `make paper-encodings`.

mod encodings;

fn main() {
    print!("{}{}", encodings::page(), encodings::speed());
}

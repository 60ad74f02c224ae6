//! Prints what each gamut method and intent of `xyz2rgb` does to three sets of colours, as Markdown: `make intents`.

mod gamut;

fn main() {
    print!("{}", gamut::page());
}

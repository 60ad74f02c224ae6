//! The methods, each run through the filter `xyz2rgb` itself.

use clap::FromArgMatches;
use luxpipe::color::Primaries;
use luxpipe::display::Display;
use luxpipe::filter::{self, Filter, Product, Run};
use luxpipe::filters::Xyz2rgb;
use luxpipe::stream::{Block, Picture, Units};

use super::sets::Strip;

/// The rows of the tables: options of `xyz2rgb`.
pub const METHODS: [&str; 9] = [
    "--intent colorimetric",
    "--intent saturation",
    "--intent perceptual",
    "--intent perceptual --hue oklab",
    "--gamut compress --knee 1",
    "--gamut shrink",
    "--gamut shrink --reach visible",
    "--gamut desaturate",
    "--gamut clip",
];

fn parsed(options: &str) -> Xyz2rgb {
    let words = ["xyz2rgb"].into_iter().chain(options.split_whitespace());
    let matches = filter::command::<Xyz2rgb>().try_get_matches_from(words).expect("options of xyz2rgb");
    Xyz2rgb::from_arg_matches(&matches).expect("options of xyz2rgb")
}

/// What a display of these primaries shows for each colour. The colorimetric intent wants cd/m2: its display has a white of
/// 1 cd/m2 and a black of none.
pub fn shown(options: &str, primaries: Primaries, colours: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let (units, display) = if options.contains("colorimetric") {
        let srgb: Display = "srgb".parse().expect("shipped");
        (Units::CdM2, Some(Display { primaries, white_cd_m2: 1.0, black_cd_m2: 0.0, ..srgb }))
    } else {
        (Units::Display, None)
    };
    let filter = Xyz2rgb { to: primaries, display, ..parsed(options) };
    let rgb = pixels(through(filter, Box::new(Strip::new(colours, colours.len(), units))));
    let to_xyz = primaries.to_xyz().expect("a gamut");
    rgb.iter().map(|p| to_xyz.apply(*p)).collect()
}

/// A picture through a filter.
pub fn through<F: Filter>(filter: F, picture: Box<dyn Picture>) -> Box<dyn Picture> {
    let run = Run::default();
    match filter.start(Some(picture), &run) {
        Ok(Product::Picture(picture)) => picture,
        Ok(_) => panic!("{} made no picture", F::NAME),
        Err(e) => panic!("{}: {e}", F::NAME),
    }
}

/// All pixels of a picture with three components.
pub fn pixels(mut picture: Box<dyn Picture>) -> Vec<[f64; 3]> {
    let (mut block, mut all) = (Block::default(), Vec::new());
    while picture.next(&mut block).expect("from memory") {
        all.extend(block.data.chunks_exact(3).map(|p| [0, 1, 2].map(|i| f64::from(p[i]))));
    }
    all
}

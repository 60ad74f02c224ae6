//! Tables: spectra, fluorescent matrices, readings and calibrations of displays, curves, histograms, charts.
#![no_main]

use libfuzzer_sys::fuzz_target;
use luxpipe::display::{macbeth::Correction, readings::Readings};
use luxpipe::optics::reradiation::Reradiation;
use luxpipe::plot::data;
use luxpipe::spectral::Spectrum;

fuzz_target!(|text: &str| {
    if let Ok(spectrum) = Spectrum::from_csv(text) {
        let (low, high) = spectrum.range();
        assert!(low <= high && low.is_finite() && high.is_finite(), "{low} to {high}");
        let _ = (spectrum.at(555.0), spectrum.mean(380.0, 780.0), spectrum.product_integral(&spectrum, 380.0, 780.0));
    }
    let _ = (Reradiation::from_csv(text), Readings::parse(text), Correction::parse(text));
    let _ = (data::curve(text), data::histogram(text), data::Table::parse(text));
});

//! Luminaire files, IES LM-63.
#![no_main]

use libfuzzer_sys::fuzz_target;
use luxpipe::photometry::ies::Photometry;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(lamp) = Photometry::parse(bytes) {
        for (vertical, horizontal) in [(0.0, 0.0), (45.0, 10.0), (90.0, 359.0), (180.0, -90.0)] {
            let candela = lamp.at(vertical, horizontal);
            assert!(candela >= 0.0, "{candela} cd at {vertical}, {horizontal}");
        }
        let _ = (lamp.flux_lm(), lamp.peak());
    }
});

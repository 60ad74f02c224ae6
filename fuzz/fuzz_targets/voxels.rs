//! Mitsuba's volumes of dense voxels.
#![no_main]

use libfuzzer_sys::fuzz_target;
use luxpipe::medium::density::vol;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(volume) = vol::parse(&mut &bytes[..]) {
        assert_eq!(volume.values.len(), volume.size.iter().product::<usize>());
    }
});

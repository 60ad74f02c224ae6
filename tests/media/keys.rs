//! What scene files may say of media, and what they are told when they say something else.

use luxpipe::scene::load;

fn refused(text: &str) -> String {
    match load::parse(text, std::path::Path::new(".")) {
        Ok(_) => panic!("this was taken:\n{text}"),
        Err(e) => e.to_string(),
    }
}

#[test]
fn wrong_keys_are_named_with_their_place() {
    let body = "[materials.b]\ntype = \"boundary\"\ninterior = \"m\"\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"b\"\n";
    for (media, expected) in [
        ("[media.m]\n", "give absorption and scattering, or extinction and albedo"),
        ("[media.m]\nabsorption = -1\n", "line 2, column 14: media.m.absorption: runs from -1 to -1"),
        ("[media.m]\nextinction = 1\nalbedo = 1.5\n", "media.m.albedo"),
        ("[media.m]\nextinction = 1\nscattering = 1\n", "not both"),
        ("[media.m]\nscattering = 1\nper = \"inch\"\n", "expected km, m, cm or mm"),
        ("[media.m]\nscattering = 1\nphase = \"mie\"\n", "expected \"isotropic\", \"rayleigh\""),
        ("[media.m]\nscattering = 1\nphase = { type = \"mie\" }\n", "no phase function 'mie'"),
        ("[media.m]\nscattering = 1\nphase = { type = \"henyey_greenstein\", g = 1 }\n", "-0.9999 to 0.9999"),
        ("[media.m]\nscattering = 1\nphase = { type = \"table\", angles = [[0, 1], [90, 1]] }\n", "from 0 to 180"),
        ("[media.m]\nscattering = 1\ndensity = -1\n", "must be 0 or more"),
        ("[media.m]\nscattering = 1\ndensity = { exponential = { scale_height = 0 } }\n", "must be above 0"),
        ("[media.m]\nscattering = 1\ndensity = { grid = { file = \"none.vol\" } }\n", "none.vol"),
        ("[media.m]\nscattering = 1\nluminance = 5\n", "luminance goes with emission"),
        ("[media.m]\nscattering = 1\ncolour = 5\n", "unknown key"),
        ("medium = \"n\"\n[media.m]\nscattering = 1\n", "no medium 'n'; there are m"),
        ("[media.n]\nscattering = 1\n", "no medium 'm'; there are n"),
    ] {
        let said = refused(&format!("{media}{body}"));
        assert!(said.contains(expected), "{media}: {said}");
    }
    let said = refused("[materials.s]\ntype = \"subsurface\"\n");
    assert!(said.contains("key 'interior' is missing"), "{said}");
}

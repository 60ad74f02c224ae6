//! pplot through the real program. Places are checked against the closed form of the axes: even steps for even differences or
//! ratios between two of the axis' own numbers.

mod common;

use std::fs;
use std::path::Path;

use common::{data_path, fails, floats, run, split, stdout_of, stream};

fn svg(args: &[&str]) -> String {
    String::from_utf8(stdout_of("pplot", args, b"")).unwrap()
}

fn file(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

/// The value of an attribute.
fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
    let (_, rest) = element.split_once(&format!(" {name}=\"")).unwrap_or_else(|| panic!("no {name} in {element}"));
    rest.split('"').next().unwrap()
}

/// Elements of a class.
fn elements<'a>(svg: &'a str, class: &str) -> Vec<&'a str> {
    let mark = format!("class=\"{class}\"");
    svg.lines().filter(|l| l.contains(&mark)).collect()
}

/// Pixel of the tick with this number, along x or y.
fn tick(svg: &str, axis: &str, label: &str) -> f64 {
    let all = elements(svg, &format!("{axis}-tick"));
    let own = all.iter().find(|e| e.contains(&format!(">{label}<"))).unwrap_or_else(|| panic!("no {label} in {all:?}"));
    attribute(own, if axis == "x" { "x" } else { "y" }).parse().unwrap()
}

/// Corners of the nth curve.
fn line(svg: &str, n: usize) -> Vec<(f64, f64)> {
    let places = attribute(elements(svg, "series")[n], "points").split(' ');
    places.map(|p| p.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).unwrap()).collect()
}

fn texts(svg: &str) -> Vec<&str> {
    let texts = svg.lines().filter(|l| l.starts_with("<text"));
    texts.map(|l| l.split_once('>').unwrap().1.strip_suffix("</text>").unwrap()).collect()
}

/// Well-formed: every element closed, nothing but known entities, no bare `<` or `&` in text.
fn check_xml(svg: &str) {
    assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"") && svg.ends_with("</svg>\n"));
    let mut open = Vec::new();
    let mut rest = svg;
    while let Some((text, more)) = rest.split_once('<') {
        for part in text.split('&').skip(1) {
            assert!(["lt;", "gt;", "amp;", "quot;", "#39;"].iter().any(|e| part.starts_with(e)), "&{part}");
        }
        let (tag, more) = more.split_once('>').unwrap();
        assert!(tag.matches('"').count() % 2 == 0 && !tag.contains('&'), "<{tag}>");
        let name = |t: &str| t.split([' ', '/']).next().unwrap().to_string();
        match tag.strip_prefix('/') {
            Some(end) => assert_eq!(open.pop().unwrap(), end),
            None if tag.ends_with('/') => {}
            None => open.push(name(tag)),
        }
        rest = more;
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?} {rest}");
}

#[test]
fn two_curves_lie_where_their_logarithms_say() {
    let folder = tempfile::tempdir().unwrap();
    let a = file(folder.path(), "a.map", "# a comment\n0.1 1\n10 10\n\n1000 100\n");
    let b = file(folder.path(), "h.map", "0.5 0.5\n5000 50\n");
    let text = svg(&["--curve", &format!("linear={a}"), "--curve", &b, "--title", "T"]);
    check_xml(&text);
    let words = texts(&text);
    for word in ["linear", "h", "T", "world luminance (cd/m²)", "display value (fraction of maximum)"] {
        assert!(words.contains(&word), "{word} not in {words:?}");
    }
    let at = |value: f64| {
        let (one, hundred) = (tick(&text, "x", "1"), tick(&text, "x", "100"));
        one + (hundred - one) * value.log10() / 2.0
    };
    // The numbers stand a third of a font below their ticks: differences count.
    let up = |value: f64| (tick(&text, "y", "0.01") - tick(&text, "y", "1")) / 2.0 * value.log10();
    for (n, points) in [(0, vec![(0.1, 0.01), (10.0, 0.1), (1000.0, 1.0)]), (1, vec![(0.5, 0.01), (5000.0, 1.0)])] {
        let drawn = line(&text, n);
        assert_eq!(drawn.len(), points.len());
        for (place, (x, y)) in drawn.iter().zip(&points) {
            assert!((place.0 - at(*x)).abs() < 0.05, "{place:?} for {x}, {}", at(*x));
            assert!((place.1 - drawn[points.len() - 1].1 + up(*y)).abs() < 0.05, "{place:?} for {y}");
        }
    }
    let shown = elements(&text, "series");
    assert_ne!(attribute(shown[0], "stroke"), attribute(shown[1], "stroke"));
    assert!(!shown[0].contains("dasharray") && shown[1].contains("dasharray"));
}

#[test]
fn a_close_up_is_linear_and_cut_at_its_edge() {
    let folder = tempfile::tempdir().unwrap();
    let map = file(folder.path(), "a.map", "1 1\n2 2\n4 4\n100 100\n");
    let text = svg(&["--curve", &map, "--zoom", "5", "--ldmax", "200"]);
    let (two, four) = (tick(&text, "x", "2.0"), tick(&text, "x", "4.0"));
    let drawn = line(&text, 0);
    for (place, x) in drawn.iter().zip([1.0, 2.0, 4.0, 5.0]) {
        assert!((place.0 - two - (four - two) * (x - 2.0) / 2.0).abs() < 0.05, "{drawn:?}");
    }
    assert_eq!(drawn.len(), 4);
    // Ld / Ldmax = Lw / 200.
    let (low, high) = (tick(&text, "y", "0.005"), tick(&text, "y", "0.020"));
    assert!((drawn[2].1 - drawn[0].1 - (high - low)).abs() < 0.1, "{drawn:?}");
    fails("pplot", &["--curve", &map, "--zoom", "0.5"], b"", 1, "the curves lie at 1 to 100");
}

/// A quarter of the pixels at 1.1, three quarters at 1000 cd/m2: two bars, three to one, their ends at multiples of 0.05.
#[test]
fn a_histogram_counts_pixels() {
    let header = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nPRIMARIES= 1 0 0 1 0 0 .333 .333";
    let values: Vec<f32> = [1.1, 1010.0, 1010.0, 1010.0, 0.0].iter().flat_map(|y| [0.5, *y, 2.0]).collect();
    let picture = stream(header, "-Y 1 +X 5", &values);
    let output = run("pplot", &[], &picture);
    assert!(String::from_utf8_lossy(&output.stderr).contains("1 pixels have no luminance"));
    let text = String::from_utf8(output.stdout).unwrap();
    check_xml(&text);
    assert!(texts(&text).contains(&"log₁₀ of world luminance (cd/m²)"));
    let (zero, three) = (tick(&text, "x", "0.0"), tick(&text, "x", "3.0"));
    let step = (three - zero) / 3.0 * 0.05;
    let shapes = elements(&text, "bars");
    let corners = |e: &str| -> Vec<(f64, f64)> {
        let places = attribute(e, "points").split(' ').map(|p| p.split_once(',').unwrap());
        places.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).collect()
    };
    let (first, last) = (corners(shapes[0]), corners(shapes[1]));
    assert!((first[0].0 - zero).abs() < 0.05 && (first[2].0 - first[0].0 - step).abs() < 0.05, "{first:?}");
    assert!((last[0].0 - three).abs() < 0.05, "{last:?}");
    let height = |c: &[(f64, f64)]| c[0].1 - c[1].1;
    assert!((height(&last) / height(&first) - 3.0).abs() < 0.01, "{first:?} {last:?}");
    // Beside a curve it has an axis of its own, and the curve lies over log10 of its luminance.
    let folder = tempfile::tempdir().unwrap();
    let map = file(folder.path(), "print.map", "1 1\n1000 100\n");
    let ready = file(folder.path(), "ready.txt", "-0.5 1\n0.5 3\n1.5 0\n2.5 4\n");
    let text = svg(&["--curve", &map, "--histogram", &ready]);
    assert!(texts(&text).contains(&"counts in each step (%)") && !elements(&text, "second-tick").is_empty());
    let (one, two) = (tick(&text, "x", "1.0"), tick(&text, "x", "2.0"));
    let drawn = line(&text, 0);
    assert!(
        (drawn[0].0 - (2.0 * one - two)).abs() < 0.05 && (drawn[1].0 - (2.0 * two - one)).abs() < 0.05,
        "{drawn:?}"
    );
    assert_eq!(stdout_of("pplot", &["--histogram", "-"], &picture), stdout_of("pplot", &[], &picture));
    let piped = stdout_of("pplot", &["--curve", &map, "--histogram", "-"], &fs::read(&ready).unwrap());
    assert!(String::from_utf8(piped).unwrap() == text);
}

#[test]
fn spectra_and_tables() {
    let folder = tempfile::tempdir().unwrap();
    let own = file(folder.path(), "lamp.csv", "# unit: W\nwavelength_nm,value\n400,1\n500,3\n700,2\n");
    let text = svg(&["--spectrum", &own, "--spectrum", "sky=D65"]);
    assert!(["wavelength (nm)", "lamp", "sky"].iter().all(|w| texts(&text).contains(w)), "{:?}", texts(&text));
    let (a, b) = (tick(&text, "x", "400"), tick(&text, "x", "700"));
    let drawn = line(&text, 0);
    assert!((drawn[0].0 - a).abs() < 0.05 && (drawn[2].0 - b).abs() < 0.05, "{drawn:?}");
    let (zero, hundred) = (tick(&text, "y", "0"), tick(&text, "y", "100"));
    assert!((drawn[0].1 - drawn[1].1 - (zero - hundred) * 0.02).abs() < 0.05, "{drawn:?}");

    let csv = "method,seconds,error,note\npath,1,0.5,x\nlocal,1,0.4,y\npath,100,0.05,\nlocal,10,,z\nlocal,100,0,z\n";
    let table = file(folder.path(), "time.csv", csv);
    let args = ["--chart", &table, "--x", "seconds", "--y", "error", "--by", "method", "--log", "--labels", ",E (%)"];
    let output = run("pplot", &args, b"");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(["path", "local", "seconds", "E (%)"].iter().all(|w| texts(&text).contains(w)), "{:?}", texts(&text));
    let notes = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(notes.contains("local: left out 1 points that are not finite"), "{notes}");
    assert!(notes.contains("local: left out 1 points that the axes cannot show"), "{notes}");
    let (one, hundred) = (tick(&text, "x", "1"), tick(&text, "x", "100"));
    let drawn = line(&text, 0);
    assert!((drawn[0].0 - one).abs() < 0.05 && (drawn[1].0 - hundred).abs() < 0.05, "{drawn:?}");
    // One point is a mark.
    assert!(elements(&text, "series").iter().any(|e| e.starts_with("<circle")));
}

#[test]
fn png_has_its_size_and_is_the_same_each_time() {
    let folder = tempfile::tempdir().unwrap();
    let map = file(folder.path(), "a.map", "1 1\n100 100\n");
    let picture = folder.path().join("a.PNG");
    let picture = picture.to_str().unwrap();
    let size = ["--width", "400", "--height", "300"];
    stdout_of("pplot", &[&size[..], &["--curve", &map, picture]].concat(), b"");
    let bytes = fs::read(picture).unwrap();
    let again = stdout_of("pplot", &[&size[..], &["--curve", &map, "--kind", "png", "--threads", "1"]].concat(), b"");
    assert!(bytes == again);
    let decoded = stdout_of("ra_png", &["-r", picture], b"");
    let (_, resolution, pixels) = split(&decoded);
    assert_eq!(resolution.split_whitespace().collect::<Vec<_>>(), ["-Y", "300", "+X", "400"]);
    let pixels = floats(pixels);
    let white = pixels.iter().filter(|v| **v > 0.99).count() as f64 / pixels.len() as f64;
    assert!((0.7..0.99).contains(&white), "{white}");
    // The curve is blue, the axes are of ink.
    let blue = pixels.chunks(3).filter(|p| p[2] > p[0] + 0.2).count();
    let ink = pixels.chunks(3).filter(|p| p.iter().all(|v| *v < 0.03)).count();
    assert!(blue > 200 && ink > 500, "{blue} {ink}");
}

#[test]
fn labels_are_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let map = file(folder.path(), "a.map", "1 1\n100 100\n");
    let curve = format!("<b> & \"c\" 'd'\u{1}={map}");
    let text = svg(&["--curve", &curve, "--title", "1 < 2 & 3 > 2", "--labels", "<x>,&y"]);
    check_xml(&text);
    for word in ["&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;\u{fffd}", "1 &lt; 2 &amp; 3 &gt; 2", "&lt;x&gt;", "&amp;y"]
    {
        assert!(texts(&text).contains(&word), "{word} not in {:?}", texts(&text));
    }
    // However many the names are, they stand within the picture, or it is said to be too small.
    let many = |n: usize| (0..n).flat_map(|i| ["--curve".into(), format!("a rather long name, {i}={map}")]).collect();
    let (some, more): (Vec<String>, Vec<String>) = (many(12), many(90));
    let text = svg(&some.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(texts(&text).iter().filter(|t| t.starts_with("a rather long name")).count(), 12);
    fails("pplot", &more.iter().map(String::as_str).collect::<Vec<_>>(), b"", 2, "give --height");
    let long = format!("{}={map}", "w".repeat(500));
    check_xml(&svg(&["--curve", &long]));
}

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let make = |name: &str, text: &str| file(folder.path(), name, text);
    let good = make("good.map", "1 1\n10 10\n");
    let curves = [
        ("", "no line of world and display luminance"),
        ("1 2\n3\n", "line 2: expected world and display luminance"),
        ("1 2 3\n", "line 1"),
        ("a b\n", "line 1"),
        ("1 0\n", "no display luminance is above 0"),
        ("nan 1\n", "nothing to draw"),
        ("0 1\n-1 2\n", "nothing to draw"),
    ];
    for (text, word) in curves {
        fails("pplot", &["--curve", &make("bad.map", text)], b"", 1, word);
    }
    let histograms = [
        ("0 1\n", "at least two lines"),
        ("0 1\n0 2\n", "line 2: log10 luminance must rise"),
        ("0 1\n1 2\n3 2\n", "line 3"),
        ("0 1\n1 -2\n", "line 2: a count"),
        ("0 0\n1 0\n", "all counts are 0"),
        ("0 1\n1 x\n", "line 2"),
    ];
    for (text, word) in histograms {
        fails("pplot", &["--histogram", &make("bad.txt", text)], b"", 1, word);
    }
    let tables = [
        ("", "column names"),
        ("1,2\n3,4\n", "line 1: expected column names"),
        ("a,b\n1\n", "line 2: expected 2 cells"),
        ("a,b\n1,x\n", "line 2: expected a number in column 'b', got 'x'"),
        ("a,c\n1,2\n", "no column 'b'; there are a, c"),
        ("a,b\n", "nothing to draw"),
    ];
    for (text, word) in tables {
        fails("pplot", &["--chart", &make("bad.csv", text), "--x", "a", "--y", "b"], b"", 1, word);
    }
    fails("pplot", &["--curve", "/nowhere"], b"", 1, "No such file");
    fails("pplot", &["--spectrum", "cc_ohta_05_blue_flowr"], b"", 1, "did you mean");
    fails("pplot", &["--histogram", &data_path("display_readings.csv")], b"", 1, "display_readings.csv");
    fails("pplot", &[], b"", 1, "");
    let target = folder.path().join("x.jpg");
    fails("pplot", &["--curve", &good, target.to_str().unwrap()], b"", 2, "expected .svg or .png");
    assert!(!target.exists());
    fails("pplot", &["--curve", &good, "--width", "10"], b"", 2, "200 to 8192 pixels wide");
    fails("pplot", &["--curve", &good, "--x-range", "-1:5"], b"", 2, "logarithmic");
    fails("pplot", &["--curve", &good, "--zoom", "-1"], b"", 2, "--zoom");
    fails("pplot", &["--curve", &good, "--labels", "a,b,c"], b"", 2, "2 axes");
    fails("pplot", &["--curve", &good, "--spectrum", "A"], b"", 2, "cannot be used");
}

/// Whatever the numbers are, there is a chart or an error.
#[test]
fn extreme_numbers_are_drawn_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    for text in [
        "1 1\n",
        "1 1\n1 1\n",
        "1e-300 1\n1e300 1e-300\n",
        "5 0\n6 1e-320\n",
        "1e308 1e308\n1e-308 1\n",
        "1 1e38\n1.0000000001 1e38\n",
    ] {
        let map = file(folder.path(), "a.map", text);
        for more in [
            &[][..],
            &["--linear"],
            &["--zoom", "1e300"],
            &["--zoom", "1e-300"],
            &["--y-range", "1:1.0000000000000002"],
        ] {
            let output = run("pplot", &[&["--curve", &map], more].concat(), b"");
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(matches!(output.status.code(), Some(0..=2)), "{text:?} {more:?}: {message}");
            let drawn = String::from_utf8(output.stdout).unwrap();
            assert!(!drawn.contains("NaN") && !drawn.contains("inf,") && !drawn.contains("inf "), "{text:?} {more:?}");
            let png = run("pplot", &[&["--kind", "png", "--curve", &map], more].concat(), b"");
            assert_eq!(png.status.code(), output.status.code(), "{text:?} {more:?}");
        }
    }
}

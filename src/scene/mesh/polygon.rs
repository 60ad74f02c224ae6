//! Polygons to triangles: a fan where one will do, else ears cut off [Meisters 1975, "Polygons have ears"].

use glam::{DVec2, DVec3};

use super::check::THIN;

/// Ears are looked for among so many corners; the search takes the square of it and more.
const MOST_CORNERS: usize = 256;

/// Cuts a polygon of three corners and more, as triples of indices into `p`. A polygon without area, or with the same corner
/// twice in a row, comes back as a fan, faults and all: they are for the caller to judge.
pub fn cut(p: &[DVec3]) -> Result<Vec<[usize; 3]>, String> {
    let n = p.len();
    let fan = |apex: usize| (1..n - 1).map(move |i| [apex, (apex + i) % n, (apex + i + 1) % n]);
    // Newell's normal: what the outline encloses, whatever its bends.
    let normal: DVec3 = fan(0).map(|t| area(t.map(|i| p[i]))).sum();
    let twice = (0..n).any(|i| p[i] == p[(i + 1) % n]);
    let size = p.iter().map(|q| q.distance_squared(p[0])).fold(0.0, f64::max);
    if twice || normal.length() <= THIN * size || !normal.is_finite() {
        return Ok(fan(0).collect());
    }
    let up = normal.normalize();
    // A fan of triangles that all turn the right way covers what the outline encloses.
    let good = |apex: usize| fan(apex).all(|t| area(t.map(|i| p[i])).dot(up) > THIN * longest(t.map(|i| p[i])));
    let apexes = if n <= MOST_CORNERS { n } else { 1 };
    if let Some(apex) = (0..apexes).find(|a| good(*a)) {
        return Ok(fan(apex).collect());
    }
    if n > MOST_CORNERS {
        return Err(format!("a face of {n} corners that is not convex: at most {MOST_CORNERS} can be cut"));
    }
    let (u, v) = up.any_orthonormal_pair();
    let flat: Vec<DVec2> = p.iter().map(|q| DVec2::new((*q - p[0]).dot(u), (*q - p[0]).dot(v))).collect();
    ears(&flat)
}

/// Twice a triangle's area, along its normal.
fn area([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The square of a triangle's longest edge.
fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
}

/// Cuts a counter-clockwise outline ear by ear.
fn ears(p: &[DVec2]) -> Result<Vec<[usize; 3]>, String> {
    let turn = |a: usize, b: usize, c: usize| (p[b] - p[a]).perp_dot(p[c] - p[a]);
    let bends = |a: usize, b: usize, c: usize| {
        let edges = [p[a] - p[b], p[b] - p[c], p[c] - p[a]].map(DVec2::length_squared);
        turn(a, b, c) > THIN * edges.into_iter().fold(0.0, f64::max)
    };
    let mut left: Vec<usize> = (0..p.len()).collect();
    let mut out = Vec::new();
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| {
            let (a, b, c) = (left[(i + n - 1) % n], left[i], left[(i + 1) % n]);
            // Outlines that reach a hole by a bridge pass twice through a place: only other places stand in the way.
            let inside = |&q: &usize| {
                let elsewhere = [a, b, c].iter().all(|&k| p[k] != p[q]);
                elsewhere && turn(a, b, q) >= 0.0 && turn(b, c, q) >= 0.0 && turn(c, a, q) >= 0.0
            };
            bends(a, b, c) && !left.iter().any(inside)
        });
        let Some(i) = ear else { return Err("the outline of the face crosses or touches itself".into()) };
        out.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
    }
    if bends(left[0], left[1], left[2]) {
        out.push([left[0], left[1], left[2]]);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(outline: &[[f64; 2]]) -> Vec<DVec3> {
        outline.iter().map(|q| DVec3::new(q[0], q[1], 0.0)).collect()
    }

    /// Every triangle turns as the outline does, and together they have its area (the shoelace formula).
    fn covers(outline: &[[f64; 2]]) {
        let p = flat(outline);
        let n = p.len();
        let shoelace: f64 = (0..n).map(|i| p[i].truncate().perp_dot(p[(i + 1) % n].truncate())).sum();
        let cut = cut(&p).unwrap();
        let areas: Vec<f64> = cut.iter().map(|t| area(t.map(|i| p[i])).z).collect();
        assert!(areas.iter().all(|a| a * shoelace > 0.0), "{outline:?}: {cut:?}");
        assert!((areas.iter().sum::<f64>() - shoelace).abs() < 1e-9, "{outline:?}: {cut:?}");
    }

    #[test]
    fn convex_ones_are_fans_about_their_first_corner() {
        let square = flat(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
        assert_eq!(cut(&square).unwrap(), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn bent_outlines_are_covered_once() {
        // An arrowhead whose first fan would leave it, an L, a corner on an edge, a comb, and a clockwise U.
        covers(&[[0., 0.], [2., -1.], [0., 2.], [0.5, 0.]]);
        covers(&[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]]);
        covers(&[[0., 0.], [1., 0.], [2., 0.], [2., 1.], [0., 1.]]);
        let comb: Vec<[f64; 2]> =
            (0..20).map(|i| [f64::from(i), f64::from(i % 2) * 3.0]).chain([[19.0, 5.0], [0.0, 5.0]]).collect();
        covers(&comb);
        covers(&[[0., 0.], [0., 3.], [1., 3.], [1., 1.], [2., 1.], [2., 3.], [3., 3.], [3., 0.]]);
        // A square with a square hole, joined by a bridge.
        covers(&[[0., 0.], [4., 0.], [4., 4.], [0., 4.], [0., 0.], [1., 1.], [1., 3.], [3., 3.], [3., 1.], [1., 1.]]);
    }

    #[test]
    fn what_cannot_be_cut_is_said_or_left_to_the_caller() {
        assert!(cut(&flat(&[[0., 0.], [2., 2.], [0., 2.], [3., 0.], [3., 0.5]])).unwrap_err().contains("crosses"));
        assert_eq!(cut(&flat(&[[0., 0.], [1., 0.], [2., 0.], [3., 0.]])).unwrap(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut(&flat(&[[0., 0.], [1., 0.], [1., 0.], [0., 1.]])).unwrap(), [[0, 1, 2], [0, 2, 3]]);
        let star = |n: usize| -> Vec<DVec3> {
            let corner = |i: usize| DVec2::from_angle(std::f64::consts::TAU * i as f64 / n as f64) * [1.0, 0.2][i % 2];
            (0..n).map(|i| corner(i).extend(0.0)).collect()
        };
        assert_eq!(cut(&star(256)).unwrap().len(), 254);
        assert!(cut(&star(258)).unwrap_err().contains("258 corners"));
    }
}

//! Brute-force oracle: free segments and rectangles from distances between segments, and Dijkstra's algorithm over all
//! cells with a linear scan.

use crate::geometry::Shape;
use crate::plan::dimibot::*;
pub use crate::random::support::Random;

type P = [f64; 2];

pub struct Oracle<'a> {
    pub lattice: Lattice,
    pub obstacles: &'a [FieldObstacle],
}

impl Oracle<'_> {
    /// The closed rectangle spanned by two cells touches no obstacle.
    pub fn free(&self, a: LatticeCell, b: LatticeCell) -> bool {
        !self.obstacles.iter().any(|o| self.hits(o, a, b))
    }

    fn hits(&self, obstacle: &FieldObstacle, a: LatticeCell, b: LatticeCell) -> bool {
        match obstacle {
            FieldObstacle::Cells { from, to } => {
                let meets =
                    |p: u32, q: u32, f: u32, t: u32| (p.min(q)..=p.max(q)).any(|v| v >= f.min(t) && v <= f.max(t));
                meets(a.x, b.x, from[0], to[0]) && meets(a.y, b.y, from[1], to[1])
            }
            FieldObstacle::Physical { shape, pose, growth_um } => {
                let (p, q) = (self.place(a), self.place(b));
                let outline = [p, [q[0], p[1]], q, [p[0], q[1]]];
                let turn = |[x, y]: P| {
                    let (s, c) = pose.heading_rad.sin_cos();
                    [pose.x_um + c * x - s * y, pose.y_um + s * x + c * y]
                };
                let (corners, radius) = corners(shape);
                let corners: Vec<P> = corners.into_iter().map(turn).collect();
                apart(&outline, &corners) <= radius + growth_um + 5e-10
            }
        }
    }

    fn place(&self, cell: LatticeCell) -> P {
        [f64::from(cell.x) * self.lattice.pitch_um[0], f64::from(cell.y) * self.lattice.pitch_um[1]]
    }

    pub fn cells(&self) -> Vec<LatticeCell> {
        let [l, r] = self.lattice.modules;
        (0..1 << l).flat_map(|x| (0..1 << r).map(move |y| LatticeCell::new(x, y))).collect()
    }

    /// Least cost by Dijkstra's algorithm without a heap.
    pub fn cost(&self, start: LatticeCell, goal: LatticeCell, weight: impl Fn(Flip) -> u64) -> Option<u64> {
        let cells = self.cells();
        let mut cost = vec![u64::MAX; cells.len()];
        let mut done = vec![false; cells.len()];
        let index = |c: LatticeCell| (c.x as usize) << self.lattice.modules[1] | c.y as usize;
        if !self.free(start, start) {
            return None;
        }
        cost[index(start)] = 0;
        loop {
            let open = (0..cells.len()).filter(|&k| !done[k] && cost[k] < u64::MAX);
            let k = open.min_by_key(|&k| cost[k])?;
            if cells[k] == goal {
                return Some(cost[k]);
            }
            done[k] = true;
            for side in [Side::Left, Side::Right] {
                for module in 0..self.lattice.modules[side.index()] as u8 {
                    let flip = Flip { side, module };
                    let next = cells[k].after(flip);
                    if !done[index(next)] && self.free(cells[k], next) {
                        cost[index(next)] = cost[index(next)].min(cost[k] + weight(flip));
                    }
                }
            }
        }
    }

    /// Fewest pulses by breadth-first search over all sets of modules.
    pub fn pulses(&self, start: LatticeCell, goal: LatticeCell) -> Option<usize> {
        let cells = self.cells();
        let mut layer: Vec<LatticeCell> = vec![start].into_iter().filter(|c| self.free(*c, *c)).collect();
        let mut seen: std::collections::BTreeSet<LatticeCell> = layer.iter().copied().collect();
        for count in 0.. {
            if layer.contains(&goal) {
                return Some(count);
            }
            let reach = |c: &LatticeCell| cells.iter().copied().filter(|d| self.free_pulse(*c, *d)).collect::<Vec<_>>();
            layer = layer.iter().flat_map(reach).filter(|d| seen.insert(*d)).collect();
            if layer.is_empty() {
                return None;
            }
        }
        None
    }

    /// Whether all modules that differ between the two cells may switch at once.
    pub fn free_pulse(&self, a: LatticeCell, b: LatticeCell) -> bool {
        self.free(LatticeCell::new(a.x & b.x, a.y & b.y), LatticeCell::new(a.x | b.x, a.y | b.y))
    }
}

fn corners(shape: &Shape) -> (Vec<P>, f64) {
    match shape {
        Shape::Point => (vec![[0.0, 0.0]], 0.0),
        Shape::Disc { radius_um } => (vec![[0.0, 0.0]], *radius_um),
        Shape::Box { size_um: [w, h] } => {
            let (a, b) = (w / 2.0, h / 2.0);
            (vec![[a, b], [-a, b], [-a, -b], [a, -b]], 0.0)
        }
        Shape::Polygon { points_um } => (points_um.clone(), 0.0),
        Shape::Capsule { length_um, radius_um } => (vec![[length_um / 2.0, 0.0], [-length_um / 2.0, 0.0]], *radius_um),
    }
}

/// Distance between two filled outlines, each a point, a segment or a polygon.
fn apart(a: &[P], b: &[P]) -> f64 {
    if inside(a[0], b) || inside(b[0], a) {
        return 0.0;
    }
    let pairs = sides(a).flat_map(|s| sides(b).map(move |t| segments_apart(s, t)));
    pairs.fold(f64::INFINITY, f64::min)
}

fn sides(outline: &[P]) -> impl Iterator<Item = [P; 2]> + '_ {
    (0..outline.len()).map(|k| [outline[k], outline[(k + 1) % outline.len()]])
}

/// Whether a polygon contains a point, by the sum of the angles that its sides subtend.
fn inside(p: P, outline: &[P]) -> bool {
    let angle = |[a, b]: [P; 2]| {
        let (u, v) = (minus(a, p), minus(b, p));
        cross(u, v).atan2(u[0] * v[0] + u[1] * v[1])
    };
    outline.len() > 2 && sides(outline).map(angle).sum::<f64>().abs() > 3.0
}

fn segments_apart([a, b]: [P; 2], [c, d]: [P; 2]) -> f64 {
    let side = |p: P, q: P, r: P| cross(minus(q, p), minus(r, p));
    if side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0 {
        return 0.0;
    }
    let ends = [to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

fn to_segment(p: P, a: P, b: P) -> f64 {
    let (run, to) = (minus(b, a), minus(p, a));
    let square = run[0] * run[0] + run[1] * run[1];
    let t = if square > 0.0 { (run[0] * to[0] + run[1] * to[1]) / square } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    (to[0] - t * run[0]).hypot(to[1] - t * run[1])
}

fn minus(a: P, b: P) -> P {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: P, b: P) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

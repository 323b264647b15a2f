//! Scenes and queries from fixed seeds.

#[path = "../../tests/support/random.rs"]
mod random;

pub use random::Random;
use tweeze::plan::dimibot::{FieldObstacle, Lattice, LatticeCell, LatticeField, SwitchWeights};

pub struct Scene {
    pub modules: u32,
    pub field: LatticeField,
    pub cells: Vec<[u32; 2]>,
    pub weights: SwitchWeights,
    pub seed: u64,
}

impl Scene {
    pub fn sparse(modules: u32, seed: u64) -> Self {
        let mut random = Random::new(seed.wrapping_mul(1000) + u64::from(modules));
        let count = random.below(6);
        Scene::with(modules, count, seed, random)
    }

    pub fn dense(modules: u32, crowd: u32, seed: u64) -> Self {
        let random = Random::new(seed.wrapping_mul(1000) + u64::from(modules * 100 + crowd));
        Scene::with(modules, crowd << modules, seed, random)
    }

    /// The same scene, without any cached results.
    pub fn again(&self) -> Self {
        Scene::of(self.modules, self.cells.clone(), self.seed)
    }

    fn with(modules: u32, count: u32, seed: u64, mut random: Random) -> Self {
        let side = 1 << modules;
        let cells: Vec<[u32; 2]> = (0..count).map(|_| [random.below(side), random.below(side)]).collect();
        Scene::of(modules, cells, seed)
    }

    fn of(modules: u32, cells: Vec<[u32; 2]>, seed: u64) -> Self {
        let lattice = Lattice::new([modules; 2], [1e-3; 2]).expect("a valid lattice");
        let obstacles: Vec<FieldObstacle> = cells.iter().map(|&c| FieldObstacle::Cells { from: c, to: c }).collect();
        let field = LatticeField::new(lattice, &obstacles).expect("a valid scene");
        let weights = SwitchWeights::distance(&lattice);
        Scene { modules, field, cells, weights, seed }
    }

    /// Pairs of free cells.
    pub fn queries(&self, count: usize, seed: u64) -> Vec<(LatticeCell, LatticeCell)> {
        let mut random = Random::new(seed ^ (self.seed << 20));
        let side = 1 << self.modules;
        let mut free = || loop {
            let cell = LatticeCell::new(random.below(side), random.below(side));
            if self.field.legal(cell).is_some() {
                return cell;
            }
        };
        (0..count).map(|_| (free(), free())).collect()
    }
}

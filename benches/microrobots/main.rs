//! Microrobots on one voltage: cost of their compiler, beside plain searches on the same work in the same run, and
//! quality of their plans on random fields.
//!
//! `cargo bench --bench microrobots` prints all tables, `-- states` one of them, `-- fastest 8` with 8 programs of
//! each kind. Instances come from fixed seeds.

mod answers;
mod assemblies;
#[path = "../electrode_array/clock.rs"]
mod clock;
mod fields;
mod goals;
mod relays;
mod rival;
mod simple;

fn main() {
    let filter = std::env::args().skip(1).find(|argument| !argument.starts_with('-')).unwrap_or_default();
    let tables: [(&str, fn()); 9] = [
        ("check", relays::check),
        ("states", relays::states),
        ("assemblies", assemblies::table),
        ("answers", answers::table),
        ("bounds", goals::bounds),
        ("fastest", goals::fastest),
        ("written", goals::written),
        ("safest", goals::safest),
        ("drives", goals::drives),
    ];
    for (_, table) in tables.iter().filter(|(name, _)| name.contains(&filter)) {
        table();
    }
}

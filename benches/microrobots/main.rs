//! Microrobots on one voltage: what their compiler costs, beside plain searches on the same work in the same run.
//!
//! `cargo bench --bench microrobots` prints all tables, `-- states` one of them. Instances come from fixed seeds.

mod assemblies;
#[path = "../electrode_array/clock.rs"]
mod clock;
mod relays;
mod rival;

fn main() {
    let filter = std::env::args().skip(1).find(|argument| !argument.starts_with('-')).unwrap_or_default();
    let tables: [(&str, fn()); 3] =
        [("check", relays::check), ("states", relays::states), ("assemblies", assemblies::table)];
    for (_, table) in tables.iter().filter(|(name, _)| name.contains(&filter)) {
        table();
    }
}

//! Cells of named parts in a state of a board.
//!
//! A schedule has a state for each step of the board, and assays have millions of them: the names are shared, and a
//! state is one allocation of twelve bytes for each part.

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// Column and row of each part, both from 1, by its name.
#[derive(Debug, Clone, Default)]
pub struct PartCells {
    /// Names in order, each once; shared with other states, so that some of them may not be listed.
    names: Arc<[Arc<str>]>,
    /// Indices into the names, in order, each once, with the cells.
    cells: Box<[(u32, [u32; 2])]>,
}

impl PartCells {
    /// From names in order, each once, and the cells of some of them by their indices, also in order.
    pub fn in_order(names: Arc<[Arc<str>]>, cells: Box<[(u32, [u32; 2])]>) -> PartCells {
        PartCells { names, cells }
    }

    /// The cell of a part; `None` if it is not listed.
    pub fn get(&self, name: &str) -> Option<[u32; 2]> {
        let place = self.cells.binary_search_by(|(nth, _)| (*self.names[*nth as usize]).cmp(name)).ok()?;
        self.cells.get(place).map(|(_, cell)| *cell)
    }

    /// Whether a part is listed.
    pub fn contains(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// Number of parts.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether no part is listed.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The parts with their cells, in order of the names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, [u32; 2])> {
        self.cells.iter().map(|(nth, cell)| (&*self.names[*nth as usize], *cell))
    }
}

impl PartialEq for PartCells {
    fn eq(&self, other: &PartCells) -> bool {
        self.iter().eq(other.iter())
    }
}

/// Of parts with the same name, the last one counts.
impl FromIterator<(Arc<str>, [u32; 2])> for PartCells {
    fn from_iter<I: IntoIterator<Item = (Arc<str>, [u32; 2])>>(parts: I) -> PartCells {
        let named: BTreeMap<Arc<str>, [u32; 2]> = parts.into_iter().collect();
        let cells = (0..).zip(named.values().copied()).collect();
        PartCells { names: named.into_keys().collect(), cells }
    }
}

impl Serialize for PartCells {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

impl<'de> Deserialize<'de> for PartCells {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<PartCells, D::Error> {
        deserializer.deserialize_map(ReadPartCells)
    }
}

/// Reads cells from a map.
struct ReadPartCells;

impl<'de> Visitor<'de> for ReadPartCells {
    type Value = PartCells;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a map from names of parts to columns and rows")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<PartCells, A::Error> {
        let mut named = Vec::new();
        while let Some((name, cell)) = map.next_entry::<String, [u32; 2]>()? {
            named.push((Arc::from(name), cell));
        }
        Ok(named.into_iter().collect())
    }
}

/// For tests that change a state.
#[cfg(test)]
impl PartCells {
    /// Puts a part on a cell, or takes it out.
    pub fn set(&mut self, name: &str, cell: Option<[u32; 2]>) {
        let others = self.iter().filter(|(other, _)| *other != name);
        *self = others.chain(cell.map(|cell| (name, cell))).map(|(name, cell)| (Arc::from(name), cell)).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_of_two_cells_of_a_part_counts() {
        let cells: PartCells = serde_json::from_str(r#"{ "b": [1, 2], "a": [3, 4], "b": [5, 6] }"#).expect("a map");
        assert_eq!(cells.iter().collect::<Vec<_>>(), [("a", [3, 4]), ("b", [5, 6])]);
        assert_eq!((cells.get("b"), cells.get("c"), cells.len()), (Some([5, 6]), None, 2));
        assert_eq!(serde_json::to_string(&cells).expect("text"), r#"{"a":[3,4],"b":[5,6]}"#);
    }
}

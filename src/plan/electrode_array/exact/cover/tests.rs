use super::*;

fn edge(one: usize, other: usize, weight: u32) -> Edge {
    Edge { ends: [one, other], weight }
}

/// Tries every rise of up to `most` for each agent.
fn plain(edges: &[Edge], agents: u32, most: u32) -> u32 {
    let rise = |code: u32, agent: usize| code / (most + 1).pow(agent as u32) % (most + 1);
    let codes = 0..(most + 1).pow(agents);
    let covers =
        |code: &u32| edges.iter().all(|edge| edge.ends.iter().map(|end| rise(*code, *end)).sum::<u32>() >= edge.weight);
    codes.filter(covers).map(|code| (0..agents as usize).map(|agent| rise(code, agent)).sum()).min().unwrap()
}

#[test]
fn covers_are_least() {
    for edges in [
        vec![],
        vec![edge(0, 1, 2)],
        vec![edge(0, 1, 1), edge(1, 2, 1), edge(0, 2, 1)],
        vec![edge(0, 1, 2), edge(0, 2, 3), edge(0, 3, 1)],
        vec![edge(0, 1, 3), edge(1, 2, 2), edge(2, 3, 3), edge(3, 0, 1)],
        vec![edge(0, 1, 0), edge(2, 3, 1)],
    ] {
        assert_eq!(least_rise(&edges), plain(&edges, 4, 3), "{edges:?}");
    }
}

#[test]
fn many_edges_fall_back_to_a_matching() {
    let star: Vec<Edge> = (1..20).map(|end| edge(0, end, 2)).collect();
    assert_eq!(least_rise(&star), 2);
    let apart: Vec<Edge> = (0..20).map(|pair| edge(2 * pair, 2 * pair + 1, 1)).collect();
    assert_eq!(least_rise(&apart), 20);
}

//! Circles among modules.
//!
//! A module and its submodules count as one. In every module, the submodules must have an order in which each uses only
//! earlier ones. Uses of parent modules and of submodules do not count.

use std::collections::{BTreeMap, BTreeSet};

use super::modules::{Modules, Place};

/// The uses among modules.
pub type Graph = BTreeMap<String, BTreeSet<String>>;

/// For every module, the uses among its direct submodules.
pub fn siblings(modules: &Modules) -> BTreeMap<Place, Graph> {
    let mut graphs: BTreeMap<Place, Graph> = BTreeMap::new();
    for place in modules.places() {
        for used in modules.used(place) {
            let shared = place.iter().zip(&used).take_while(|(a, b)| a == b).count();
            if let (Some(user), Some(used)) = (place.get(shared), used.get(shared)) {
                let graph = graphs.entry(place[..shared].to_vec()).or_default();
                graph.entry(user.clone()).or_default().insert(used.clone());
            }
        }
    }
    graphs
}

/// Returns the circles: groups in which every member uses every other one, directly or indirectly.
pub fn circles(graph: &Graph) -> BTreeSet<Vec<String>> {
    let reached: BTreeMap<&String, BTreeSet<&String>> = graph.keys().map(|node| (node, reach(graph, node))).collect();
    let circle = |node: &&String| {
        let back = |other: &&&String| reached.get(**other).is_some_and(|reached| reached.contains(*node));
        reached[*node].iter().filter(back).map(|other| (**other).clone()).collect::<Vec<_>>()
    };
    graph.keys().filter(|node| reached[node].contains(node)).map(|node| circle(&node)).collect()
}

/// Returns the nodes that a node uses, directly or indirectly.
fn reach<'a>(graph: &'a Graph, from: &String) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<&String> = graph.get(from).into_iter().flatten().collect();
    while let Some(node) = open.pop() {
        if reached.insert(node) {
            open.extend(graph.get(node).into_iter().flatten());
        }
    }
    reached
}

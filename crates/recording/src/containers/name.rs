//! Names of signals. An array of several signals gives `name[:,1]`, where `:` stands for the samples and numbers count
//! from 0.

use super::Array;
use crate::Quantity;
use crate::error::Problem;
use crate::header::nearest;

const MAX_LISTED: usize = 32;

/// Elements of an array at a constant stride.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Vector {
    pub(crate) array: usize,
    pub(crate) name: String,
    pub(super) offset: usize,
    pub(super) stride: usize,
    pub(crate) len: usize,
}

impl Vector {
    pub(super) fn whole(index: usize, array: &Array) -> Self {
        Self { array: index, name: array.name.clone(), offset: 0, stride: 1, len: array.len() }
    }

    pub(super) fn of<'a>(&self, values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        values.iter().skip(self.offset).step_by(self.stride.max(1)).take(self.len).copied()
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Pick {
    Samples,
    Index(usize),
}

pub(crate) fn listed(dims: &[usize]) -> usize {
    let longest = dims.iter().copied().max().unwrap_or(0);
    if longest < 2 || dims.contains(&0) {
        return 0;
    }
    let all = dims.iter().fold(1_usize, |product, dim| product.saturating_mul(*dim));
    (all / longest).min(MAX_LISTED)
}

pub(crate) fn has_signals(arrays: &[Array]) -> bool {
    arrays.iter().any(|array| listed(&array.dims) > 0)
}

pub(crate) fn vectors(arrays: &[Array]) -> Vec<Vector> {
    arrays.iter().enumerate().flat_map(|(index, array)| of_array(index, array)).collect()
}

fn of_array(index: usize, array: &Array) -> Vec<Vector> {
    let Some((longest, &len)) = array.dims.iter().enumerate().rev().max_by_key(|(_, dim)| **dim) else { return vec![] };
    if len < 2 || array.dims.contains(&0) {
        return vec![];
    }
    let picks = (0..listed(&array.dims)).map(|mut number| {
        let pick = |(axis, &dim): (usize, &usize)| {
            if axis == longest {
                return Pick::Samples;
            }
            let at = number % dim;
            number /= dim;
            Pick::Index(at)
        };
        let mut picks: Vec<Pick> = array.dims.iter().enumerate().rev().map(pick).collect();
        picks.reverse();
        picks
    });
    picks.filter_map(|picks| vector(index, array, &picks)).collect()
}

/// One pick per dimension, or one per dimension with more than one element.
fn vector(index: usize, array: &Array, picks: &[Pick]) -> Option<Vector> {
    let wide: Vec<usize> = (0..array.dims.len()).filter(|axis| array.dims[*axis] > 1).collect();
    let axes: Vec<usize> = match picks.len() {
        all if all == array.dims.len() => (0..all).collect(),
        some if some == wide.len() => wide.clone(),
        _ => return None,
    };
    let stride = |axis: usize| {
        let faster = if array.column_major { &array.dims[..axis] } else { &array.dims[axis + 1..] };
        faster.iter().product::<usize>()
    };
    let mut found = Vector { array: index, name: array.name.clone(), offset: 0, stride: 0, len: 0 };
    let mut whole = vec![Pick::Index(0); array.dims.len()];
    for (&axis, &pick) in axes.iter().zip(picks) {
        whole[axis] = pick;
        match pick {
            Pick::Samples if found.len > 0 => return None,
            Pick::Samples => (found.stride, found.len) = (stride(axis), array.dims[axis]),
            Pick::Index(at) if at < array.dims[axis] => found.offset += at * stride(axis),
            Pick::Index(_) => return None,
        }
    }
    if wide.len() > 1 {
        let parts: Vec<String> = whole.iter().map(Pick::to_string).collect();
        found.name = format!("{}[{}]", array.name, parts.join(","));
    }
    (found.len > 0).then_some(found)
}

impl std::fmt::Display for Pick {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Samples => f.write_str(":"),
            Self::Index(index) => write!(f, "{index}"),
        }
    }
}

fn brackets(text: &str) -> Option<(&str, Vec<Pick>)> {
    let (base, inside) = text.strip_suffix(']')?.rsplit_once('[')?;
    let part = |part: &str| match part.trim() {
        ":" => Some(Pick::Samples),
        number => number.parse().ok().map(Pick::Index),
    };
    let picks = inside.split(',').map(part).collect::<Option<Vec<_>>>()?;
    picks.contains(&Pick::Samples).then_some((base, picks))
}

pub(super) fn find(arrays: &[Array], wanted: &str, quantity: Quantity) -> Result<Vector, Problem> {
    let (base, picks) = match arrays.iter().any(|array| array.name == wanted) {
        true => (wanted, None),
        false => brackets(wanted).map_or((wanted, None), |(base, picks)| (base, Some(picks))),
    };
    let Some(index) = named(arrays, base)? else {
        let available: Vec<String> = vectors(arrays).into_iter().map(|vector| vector.name).collect();
        let nearest = nearest(&available, wanted);
        return Err(Problem::MissingSignal { name: wanted.into(), available, nearest, quantity: Some(quantity) });
    };
    let array = &arrays[index];
    let wide: Vec<usize> = array.dims.iter().copied().filter(|dim| *dim > 1).collect();
    let found = match (picks, wide.len()) {
        (Some(picks), _) => vector(index, array, &picks),
        (None, 0 | 1) => of_array(index, array).into_iter().next(),
        (None, _) => None,
    };
    found.ok_or_else(|| {
        let dims: Vec<String> = array.dims.iter().map(usize::to_string).collect();
        let example = of_array(index, array).into_iter().next().map_or(array.name.clone(), |vector| vector.name);
        Problem::NotOneSignal { name: wanted.into(), shape: dims.join(" x ").into(), example: example.into() }
    })
}

/// Accepts a name, an alias, a name without `[0]` for parts that occur once, or the unique end of a path.
fn named(arrays: &[Array], name: &str) -> Result<Option<usize>, Problem> {
    let without_zeros = |name: &str| name.replace("[0]", "");
    // The end of a path may be a field of a message, as in `force.z`.
    let is_end = |array: &Array| array.name.strip_suffix(name).is_some_and(|before| before.ends_with(['/', '!', '.']));
    let rules: [&dyn Fn(&Array) -> bool; 5] = [
        &|array| array.name == name,
        &|array| array.aliases.iter().any(|alias| alias == name),
        &|array| without_zeros(&array.name) == without_zeros(name),
        &|array| array.name.trim_start_matches('/') == name || array.name.rsplit(['/', '!']).next() == Some(name),
        &is_end,
    ];
    for rule in rules {
        let mut found = (0..arrays.len()).filter(|index| rule(&arrays[*index]));
        match (found.next(), found.next()) {
            (None, _) => {}
            (Some(index), None) => return Ok(Some(index)),
            (Some(first), Some(second)) => {
                let candidates = [first, second].into_iter().chain(found).map(|index| arrays[index].name.clone());
                return Err(Problem::AmbiguousSignal { name: name.into(), candidates: candidates.collect() });
            }
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(array: &Array) -> Vec<String> {
        vectors(std::slice::from_ref(array)).into_iter().map(|vector| vector.name).collect()
    }

    fn values(array: &Array, name: &str) -> Vec<f64> {
        let all: Vec<f64> = (0..array.len()).map(|index| index as f64).collect();
        let vector = find(std::slice::from_ref(array), name, Quantity::Force).expect(name);
        vector.of(&all).collect()
    }

    #[test]
    fn a_column_is_picked_in_either_order_of_the_elements() {
        let by_rows = Array::new("a", vec![3, 2]);
        let by_columns = Array { column_major: true, ..by_rows.clone() };
        assert_eq!(names(&by_rows), ["a[:,0]", "a[:,1]"]);
        assert_eq!(values(&by_rows, "a[:,1]"), [1.0, 3.0, 5.0]);
        assert_eq!(values(&by_columns, "a[:,1]"), [3.0, 4.0, 5.0]);
        assert_eq!(values(&by_columns, "a[ 2 , : ]"), [2.0, 5.0]);
    }

    #[test]
    fn one_signal_needs_no_brackets() {
        let vector = Array { column_major: true, ..Array::new("a", vec![1, 1, 4]) };
        assert_eq!(names(&vector), ["a"]);
        for name in ["a", "a[:]", "a[0,0,:]"] {
            assert_eq!(values(&vector, name), [0.0, 1.0, 2.0, 3.0], "{name}");
        }
        assert_eq!(names(&Array::new("s", vec![1, 1])), Vec::<String>::new());
        let cube = Array::new("c", vec![2, 1, 3]);
        assert_eq!(names(&cube), ["c[0,0,:]", "c[1,0,:]"]);
        assert_eq!(values(&cube, "c[1,:]"), [3.0, 4.0, 5.0]);
    }

    #[test]
    fn short_names_are_accepted_if_they_are_unique() {
        let arrays = ["/a/force", "/b/force", "/b/time", "s.signals[0].values", "s.one.values"];
        let arrays = arrays.map(|name| Array::new(name, vec![4]));
        let found = |name: &str| find(&arrays, name, Quantity::Force).map(|vector| vector.name);
        assert_eq!(found("b/force").expect("one"), "/b/force");
        assert_eq!(found("time").expect("one"), "/b/time");
        assert_eq!(found("s[0].one[0].values").expect("one"), "s.one.values");
        let refusal = |name: &str| found(name).expect_err("refused").to_string();
        assert_eq!(refusal("force"), "'force' is ambiguous: it can be /a/force, /b/force; give one of these names");
        assert!(refusal("forces").contains("no signal 'forces' (--force or recording.columns.force_n); the file has"));
    }

    #[test]
    fn an_array_of_several_signals_needs_a_column() {
        let array = Array::new("m", vec![5, 2]);
        for name in ["m", "m[:,2]", "m[:,:]", "m[:,0,0]"] {
            let refusal = find(std::slice::from_ref(&array), name, Quantity::Time).expect_err("refused").to_string();
            assert!(
                refusal.contains("is 5 x 2, not one signal; give its column, counted from 0, as in m[:,0]"),
                "{refusal}"
            );
        }
    }
}

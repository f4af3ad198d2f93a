use std::borrow::Cow;
use std::sync::Arc;

use trocar_core::error::{InvalidValue, require};
use trocar_core::settings::{Key, KeySource};

use super::TissueSettings;
use super::literature::Bounds;

/// `[[tissue.layer]]`, from the surface down.
pub const LAYER_LIST: &str = "tissue.layer";

/// With a `*` for the layer's name.
pub const LAYER_KEYS: &[Key] = TissueSettings::LIST_KEYS;

pub type Named<T> = (Arc<str>, T);

pub(super) type Measurable<'a> = (&'static str, Option<&'a str>, f64, &'static Bounds);

pub fn path_in_layer(path: &'static str, layer: Option<&str>) -> Cow<'static, str> {
    layer.map_or(Cow::Borrowed(path), |name| Cow::Owned(path.replacen('*', name, 1)))
}

pub(super) fn read_layers<S: KeySource, T>(
    source: &mut S,
    mut read: impl FnMut(&mut S) -> Result<T, S::Error>,
) -> Result<Vec<Named<T>>, S::Error> {
    let mut layers = vec![];
    source.visit_items(LAYER_LIST, |name, source| {
        layers.push((Arc::from(name), read(source)?));
        Ok(())
    })?;
    Ok(layers)
}

pub(super) fn check_layers<T>(
    layers: &[Named<T>],
    check: impl Fn(&T) -> Result<(), InvalidValue>,
) -> Result<(), InvalidValue> {
    require(LAYER_LIST, layers.len() as f64, !layers.is_empty(), "a list of at least one layer")?;
    layers.iter().enumerate().try_for_each(|(index, (_, layer))| check(layer).map_err(|error| error.of_item(index)))
}

pub(super) fn measured_layers<T, const N: usize>(
    layers: &[Named<T>],
    measured: impl Fn(&T) -> [(&'static str, f64, &'static Bounds); N],
) -> impl Iterator<Item = Measurable<'_>> {
    layers
        .iter()
        .flat_map(move |(name, layer)| measured(layer).map(|(key, value, bounds)| (key, Some(&**name), value, bounds)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_core::error::positive;

    #[test]
    fn the_first_wrong_layer_is_reported_by_index_and_an_empty_list_is_an_error() {
        let check = |value: &f64| positive("tissue.layer.*.x", *value).map(drop);
        let layers = |values: &[f64]| values.iter().map(|value| ("a".into(), *value)).collect::<Vec<_>>();
        assert_eq!(check_layers(&layers(&[1.0, 2.0]), check), Ok(()));
        let error = check_layers(&layers(&[1.0, -2.0, -3.0]), check).expect_err("refused");
        assert_eq!((error.item, error.value), (Some(1), -2.0));
        let error = check_layers(&layers(&[]), check).expect_err("refused");
        assert_eq!((error.name, error.item), (LAYER_LIST, None));
    }
}

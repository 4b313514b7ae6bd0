//! What the flags of a sweep ask for: axes, and what is set for all cells.

use super::axes::{Axis, AxisError, values};

/// Axes, and settings that are none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Request {
    /// What is swept.
    pub axes: Vec<Axis>,
    /// `KEY=VALUE` with a text or a switch: the same in every cell.
    pub settings: Vec<String>,
}

impl Request {
    /// From flags with a key of their own, and from `KEY=VALUES` texts.
    ///
    /// # Errors
    /// What is neither an axis nor a setting.
    pub fn new(flags: &[(&str, Option<&str>)], set: &[String]) -> Result<Self, AxisError> {
        let mut request = Self::default();
        for (key, spec) in flags {
            if let Some(spec) = spec {
                request.axes.push(Axis::parse(key, spec)?);
            }
        }
        for text in set {
            // Numbers never hold an equals sign, quoted keys may.
            match text.rsplit_once('=') {
                Some((key, spec)) if is_setting(key, spec) => request.settings.push(text.clone()),
                Some((key, spec)) => request.axes.push(Axis::parse(key.trim(), spec.trim())?),
                None => {
                    return Err(AxisError::NotNumbers {
                        key: text.clone(),
                        spec: String::new(),
                    });
                }
            }
        }
        Ok(request)
    }
}

/// A text, a switch or a list of them: no axis. (10:20:10 is a time of day to TOML, and an axis here.)
fn is_setting(key: &str, spec: &str) -> bool {
    let value = format!("value = {spec}").parse::<toml::Table>();
    let is_other = value.is_ok_and(|table| {
        let value = table.get("value");
        value.is_some_and(|value| value.is_str() || value.is_bool() || value.is_array())
    });
    values(key, spec).is_err() && is_other
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_and_settings_are_told_apart() {
        let set = [
            "triple.gamma=10:20:10",
            "noise_aware.merge=false",
            "map.gate = 9",
        ];
        let request = Request::new(
            &[("triple.alpha", Some("0.3,0.5")), ("triple.beta", None)],
            &set.map(ToOwned::to_owned),
        )
        .unwrap();
        let keys: Vec<String> = request.axes.iter().map(Axis::key).collect();
        assert_eq!(keys, ["triple.alpha", "triple.gamma", "map.gate"]);
        assert_eq!(request.axes[1].values, [10.0, 20.0]);
        assert_eq!(request.settings, ["noise_aware.merge=false"]);
    }

    #[test]
    fn what_is_neither_is_said() {
        let said = |text: &str| {
            let set = [text.to_owned()];
            Request::new(&[], &set).unwrap_err().to_string()
        };
        assert!(said("triple.gamma=10:20").contains("has no step"));
        assert!(said("triple.gamma").contains("neither a number"));
        assert!(said("triple.gama=1:2:1").contains("did you mean `triple.gamma`?"));
    }
}

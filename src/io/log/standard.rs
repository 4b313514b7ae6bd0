//! Definitions of ROS 2's standard types, for files that carry none.

use super::msg_schema::short;

/// All of them. `Range` is Humble's, which is where Jazzy's begins: without a definition nothing
/// tells whether the variance follows.
const DEFINITIONS: &str = include_str!("schemas/standard.msg");

/// The definition of a type with all that it contains, as a `ros2msg` schema has it; `None` for a
/// type that is not standard.
pub fn definition(type_name: &str) -> Option<String> {
    let head = format!("MSG: {}\n", short(type_name));
    let (_, behind) = DEFINITIONS.split_once(&head)?;
    let own = behind.split("===").next().unwrap_or_default();
    Some(format!("{own}===\n{DEFINITIONS}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::ros2::Decoder;

    #[test]
    fn every_definition_can_be_read() {
        let names = DEFINITIONS.lines().filter_map(|l| l.strip_prefix("MSG: "));
        for name in names {
            let definition = definition(name).unwrap();
            Decoder::new(name, definition.as_bytes()).unwrap();
        }
        assert!(definition("sensor_msgs/msg/Range").is_some());
        assert_eq!(definition("sensor_msgs/msg/Rang"), None);
    }
}

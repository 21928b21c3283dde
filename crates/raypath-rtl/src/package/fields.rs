//! Ports as the fields of nested structures: `ray_origin_x_i` becomes `ray.origin.x`.

use raypath_hdl::name_problem;
use raypath_hdl::text::TextPort;

/// A field of a structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Field {
    /// A port.
    Port {
        /// The field's name.
        name: String,
        /// The port's name.
        port: String,
        /// The port's width.
        width: u32,
    },
    /// Two or more ports with a common prefix.
    Group {
        /// Their common prefix.
        name: String,
        /// The rest.
        fields: Vec<Field>,
    },
}

/// The port with the opcode of a job or a result; its field is the first.
const OPCODE: &str = "opcode";

impl Field {
    /// These ports, the opcode first, without the beginning of their names.
    pub fn of(ports: &[TextPort], prefix: &str) -> Vec<Self> {
        fn leaf<'a>(port: &'a TextPort, prefix: &str) -> Leaf<'a> {
            // A name that is a keyword keeps its beginning, or its suffix.
            let names = [port.stem().strip_prefix(prefix).unwrap_or(port.stem()), port.stem()];
            let name = names.into_iter().find(|name| name_problem(name).is_none()).unwrap_or(&port.name);
            Leaf { name, port: &port.name, width: port.width }
        }
        let mut leaves: Vec<Leaf<'_>> = ports.iter().map(|port| leaf(port, prefix)).collect();
        leaves.sort_by_key(|leaf| leaf.name != OPCODE);
        nest(&leaves)
    }

    pub fn name(&self) -> &str {
        match self {
            Self::Port { name, .. } | Self::Group { name, .. } => name,
        }
    }
}

/// A port, and the rest of its name inside its groups.
#[derive(Debug, Clone, Copy)]
struct Leaf<'a> {
    name: &'a str,
    port: &'a str,
    width: u32,
}

/// Groups ports by prefix, in the order of the first port of each prefix.
fn nest(leaves: &[Leaf<'_>]) -> Vec<Field> {
    let mut fields = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    for leaf in leaves {
        let (head, _) = split(leaf.name);
        if seen.contains(&head) {
            continue;
        }
        seen.push(head);
        let members: Vec<Leaf<'_>> = leaves.iter().copied().filter(|leaf| split(leaf.name).0 == head).collect();
        // A prefix that is not a valid field name makes no group, nor does one that says nothing.
        match group(&members).filter(|_| name_problem(head).is_none() && head != "is") {
            Some(inner) => fields.push(Field::Group { name: head.to_string(), fields: inner }),
            None => fields.extend(members.iter().map(Leaf::field)),
        }
    }
    fields
}

/// The members without their common head. `None` if they make no structure: a single port, a port whose name is the
/// head alone, or a rest that is a keyword.
fn group(members: &[Leaf<'_>]) -> Option<Vec<Field>> {
    let inner: Option<Vec<Leaf<'_>>> =
        members.iter().map(|leaf| Some(Leaf { name: split(leaf.name).1?, ..*leaf })).collect();
    let fields = nest(&inner.filter(|inner| inner.len() > 1)?);
    fields.iter().all(|field| name_problem(field.name()).is_none()).then_some(fields)
}

/// The first word of a name, with the numbers that follow it, and the rest: `aabb_0` and `x_min`.
fn split(name: &str) -> (&str, Option<&str>) {
    let mut ends = name.match_indices('_').map(|(at, _)| at);
    let begins_a_word = |at: &usize| !name[at + 1..].starts_with(|c: char| c.is_ascii_digit());
    match ends.find(begins_a_word) {
        Some(at) if at > 0 && at + 1 < name.len() => (&name[..at], Some(&name[at + 1..])),
        _ => (name, None),
    }
}

impl Leaf<'_> {
    fn field(&self) -> Field {
        Field::Port { name: self.name.to_string(), port: self.port.to_string(), width: self.width }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every port by the path of its field.
    fn paths(ports: &[&str]) -> Vec<String> {
        fn walk(fields: &[Field], before: &str, paths: &mut Vec<String>) {
            for field in fields {
                match field {
                    Field::Port { name, .. } => paths.push(format!("{before}{name}")),
                    Field::Group { name, fields } => walk(fields, &format!("{before}{name}."), paths),
                }
            }
        }
        let leaves: Vec<Leaf<'_>> = ports.iter().map(|name| Leaf { name, port: name, width: 1 }).collect();
        let mut paths = Vec::new();
        walk(&nest(&leaves), "", &mut paths);
        paths
    }

    #[test]
    fn what_begins_alike_is_a_group() {
        let ports = ["ray_origin_x", "ray_origin_y", "ray_kx", "aabb_0_x_min", "aabb_0_x_max", "mask"];
        let expected = ["ray.origin.x", "ray.origin.y", "ray.kx", "aabb_0.x_min", "aabb_0.x_max", "mask"];
        assert_eq!(paths(&ports)[..3], expected[..3]);
        assert_eq!(paths(&ports)[3..], ["aabb_0.x.min", "aabb_0.x.max", "mask"]);
    }

    #[test]
    fn one_port_alone_keeps_its_name() {
        assert_eq!(paths(&["triangle_hit", "t_num", "t_denom"]), ["triangle_hit", "t.num", "t.denom"]);
        assert_eq!(paths(&["tmin_0", "tmin_1"]), ["tmin_0", "tmin_1"]);
        assert_eq!(paths(&["is_box", "is_opaque"]), ["is_box", "is_opaque"]);
    }

    #[test]
    fn a_port_whose_name_begins_others_is_a_field_of_its_own() {
        assert_eq!(paths(&["ray", "ray_x", "ray_y_a", "ray_y_b"]), ["ray", "ray_x", "ray_y_a", "ray_y_b"]);
    }

    #[test]
    fn no_field_is_a_keyword() {
        assert_eq!(paths(&["range_begin", "range_end"]), ["range_begin", "range_end"]);
        assert_eq!(paths(&["a_reg_x", "a_reg_y", "a_q"]), ["a.reg_x", "a.reg_y", "a.q"]);
        assert_eq!(paths(&["a_wire_1", "a_q"]), ["a.wire_1", "a.q"]);
        assert_eq!(paths(&["edge_x", "edge_y", "near_x", "near_y"]), ["edge_x", "edge_y", "near_x", "near_y"]);
    }

    #[test]
    fn groups_need_not_be_contiguous() {
        assert_eq!(paths(&["a_x", "b", "a_y"]), ["a.x", "a.y", "b"]);
    }

    #[test]
    fn odd_underscores_are_no_boundaries() {
        assert_eq!(paths(&["_a", "_b", "c_", "c_d"]), ["_a", "_b", "c_", "c_d"]);
    }
}

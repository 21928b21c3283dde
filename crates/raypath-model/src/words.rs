use crate::model::Kind;
use raypath_ops::{JobKind, Outcome, Port, PortValue};
use std::fmt;
use std::sync::Arc;

/// A job or an outcome of any operation, with a word for each of its ports. Numbers are in the IEEE 754 layout.
#[derive(Clone, PartialEq)]
pub struct Words {
    kind: OperationId,
    ports: Ports,
    words: Arc<[u64]>,
}

/// An operation of a [`WordModel`](crate::WordModel): its opcode and its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct OperationId {
    opcode: u64,
    name: &'static str,
}

/// The ports of the words of one operation.
pub(crate) type Ports = Arc<[Port]>;

impl Words {
    pub(crate) fn new(kind: OperationId, ports: Ports, words: Arc<[u64]>) -> Self {
        Self { kind, ports, words }
    }

    /// The operation.
    pub fn kind(&self) -> OperationId {
        self.kind
    }

    /// The words, in the order of the ports.
    pub fn as_words(&self) -> &[u64] {
        &self.words
    }

    /// The values of the ports with their names. The opcode is not among them.
    pub fn ports(&self) -> Vec<PortValue> {
        let values = self.ports.iter().zip(self.words.iter());
        values.map(|(port, &bits)| PortValue { name: port.name.clone(), kind: port.kind, bits }).collect()
    }

    /// An outcome of one of the paper's operations, in binary32, in its own type; `None` for other operations.
    pub fn paper_outcome(&self) -> Option<Outcome> {
        Some(Outcome::from_ports(self.kind.paper()?, |name| self.port(name)))
    }

    /// The word at a port; 0 if there is no such port.
    pub fn port(&self, name: &str) -> u64 {
        self.ports.iter().zip(self.words.iter()).find(|(port, _)| port.name == name).map_or(0, |(_, &bits)| bits)
    }
}

impl OperationId {
    pub(crate) fn new(opcode: u64, name: &'static str) -> Self {
        Self { opcode, name }
    }

    /// The operation's name.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// The value of the ports `opcode_i` and `opcode_o`.
    pub fn opcode(self) -> u64 {
        self.opcode
    }

    /// The paper's operation of this name, if it is one.
    pub fn paper(self) -> Option<JobKind> {
        self.name.parse().ok()
    }
}

impl PartialEq<JobKind> for OperationId {
    fn eq(&self, other: &JobKind) -> bool {
        self.name == other.name()
    }
}

impl Kind for OperationId {
    #[inline]
    fn opcode(self) -> u64 {
        self.opcode
    }
}

impl fmt::Display for OperationId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// `sphere: ray_origin_x=3f800000 ...`
impl fmt::Debug for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.kind)?;
        self.ports.iter().zip(self.words.iter()).try_for_each(|(port, word)| write!(f, " {}={word:x}", port.name))
    }
}

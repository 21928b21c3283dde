use crate::units::UnitKind;
use raypath_float::Format;
use raypath_hdl::{Error, Module};
use std::sync::Arc;

/// The modules that stages are made of, each built once.
#[derive(Debug)]
pub struct Library {
    pub format: Format,
    pub skid: Arc<Module>,
    encode: Arc<Module>,
    add: Arc<Module>,
    multiply: Arc<Module>,
    compare: Arc<Module>,
    decode: Arc<Module>,
}

impl Library {
    pub fn new(format: Format) -> Result<Self, Error> {
        Ok(Self {
            format,
            skid: crate::skid::skid()?,
            encode: raypath_float::encode(format)?,
            add: raypath_float::add(format)?,
            multiply: raypath_float::mul(format)?,
            compare: raypath_float::compare(format)?,
            decode: raypath_float::decode(format)?,
        })
    }

    pub fn unit(&self, kind: UnitKind) -> &Arc<Module> {
        match kind {
            UnitKind::Encode => &self.encode,
            UnitKind::Add => &self.add,
            UnitKind::Multiply => &self.multiply,
            UnitKind::Compare => &self.compare,
            UnitKind::Decode => &self.decode,
        }
    }
}

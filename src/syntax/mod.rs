//! Text to tree.
pub mod tree;
use crate::diagnostic::Sink;
use crate::source::FileId;
pub fn parse(_: FileId, _: &str, _: &mut Sink) -> tree::Tree {
    unimplemented!()
}
pub fn parse_value(_: FileId, _: &str, _: &mut Sink) -> Option<tree::Expr> {
    unimplemented!()
}

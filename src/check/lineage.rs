//! Chains of bases of devices and scenes, followed without recursion.

use super::scope::DeclarationPlace;
use super::{Checker, errors};
use crate::syntax::tree::{self, Item};
use std::collections::BTreeSet;

/// Base of a declaration.
pub enum Base<R> {
    /// Nothing further: a device's kind, or no other scene.
    Root(R),
    Of(DeclarationPlace),
    /// A diagnostic was pushed.
    Broken,
}

impl Checker<'_> {
    /// From `place` down to the last declaration that is not known yet, each with its base. A cycle is reported once
    /// and cut.
    pub fn lineage<R>(
        &mut self,
        place: DeclarationPlace,
        is_known: &dyn Fn(&mut Self, DeclarationPlace) -> bool,
        base: &dyn Fn(&mut Self, DeclarationPlace) -> Base<R>,
    ) -> Vec<(DeclarationPlace, Base<R>)> {
        let mut chain: Vec<(DeclarationPlace, Base<R>)> = Vec::new();
        let mut seen: BTreeSet<DeclarationPlace> = BTreeSet::new();
        let mut at = place;
        while !is_known(self, at) {
            if !seen.insert(at) {
                self.cut(at, &mut chain);
                break;
            }
            let next = base(self, at);
            let further = match &next {
                Base::Of(further) => Some(*further),
                Base::Root(_) | Base::Broken => None,
            };
            chain.push((at, next));
            match further {
                Some(further) => at = further,
                None => break,
            }
        }
        chain
    }

    fn cut<R>(&mut self, at: DeclarationPlace, chain: &mut [(DeclarationPlace, Base<R>)]) {
        let Some((last, base)) = chain.last_mut() else { return };
        *base = Base::Broken;
        let path = match self.item(*last) {
            Item::Device(item) | Item::Instrument(item) | Item::Output(item) => Some(&item.base),
            Item::Scene(item) => item.base.as_ref(),
            Item::Use(_) | Item::Let(_) | Item::Task(_) | Item::Program(_) | Item::Wiring(_) | Item::Error(_) => None,
        };
        if let Some(tree::Path { span, .. }) = path {
            let (name, declared) = self.named(at);
            self.sink.push(errors::defined_by_itself(name, declared, *span));
        }
    }
}

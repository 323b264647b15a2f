//! Values: from `35 um` to tables.

use super::cursor::HOLE;
use super::grammar::{Grammar, Node, Rule, STRENGTHS};
use super::known_mistakes;
use super::reader::Reader;
use super::tree::{Column, Expr, ExprKind, Field, Ident, IndexedName, Operator, Path, Row, Table, Text, TextPart};
use super::{MAX_OPERATORS, errors};
use crate::source::Span;
use pest::Parser;

impl Reader<'_> {
    /// Reads an expression of any of the grammar's three sorts.
    pub fn expr(&mut self, node: Node) -> Expr {
        // Most expressions are a single value without an operator.
        let mut inner = node.clone().into_inner();
        if inner.len() == 1
            && let Some(part) = inner.next()
            && !is_operator(part.as_rule())
        {
            return self.primary(part);
        }
        let span = self.span(&node);
        let mut parts = self.children(node);
        if parts.len() == 1
            && let Some(part) = parts.pop()
        {
            return self.primary(part);
        }
        let operators = parts.iter().filter(|part| is_operator(part.as_rule())).count();
        if self.operators + operators > MAX_OPERATORS {
            self.report(errors::too_many_operators(span, self.operators + operators));
            return Expr { kind: ExprKind::Error, span };
        }
        self.operators += operators;
        let expr = self.combine(parts);
        self.operators -= operators;
        expr
    }

    fn combine(&mut self, parts: Vec<Node>) -> Expr {
        let origin = self.origin;
        STRENGTHS
            .map_primary(|node| self.primary(node))
            .map_prefix(|sign, value| {
                let span = origin.span(&sign).to(value.span);
                Expr { kind: ExprKind::Negative(Box::new(value)), span }
            })
            .map_infix(|left, node, right| join(left, &node, origin.span(&node), right))
            .parse(parts.into_iter())
    }

    fn primary(&mut self, node: Node) -> Expr {
        let span = self.span(&node);
        let kind = match node.as_rule() {
            Rule::missing => return self.missing(&node),
            Rule::expr | Rule::step_expr | Rule::flat_expr => return self.expr(node),
            Rule::bits => ExprKind::Word(node.as_str()[2..].to_owned()),
            Rule::boolean => ExprKind::Bool(node.as_str() == "true"),
            Rule::quantity => self.quantity(node),
            Rule::text => ExprKind::Text(self.text(node)),
            Rule::table => self.table(node),
            Rule::list => ExprKind::List(self.values(node)),
            Rule::tuple => return self.tuple(node),
            Rule::named | Rule::step_named | Rule::flat_named => self.named(node),
            _ => ExprKind::Error,
        };
        Expr { kind, span }
    }

    fn values(&mut self, node: Node) -> Vec<Expr> {
        self.children(node).into_iter().map(|child| self.primary(child)).collect()
    }

    fn tuple(&mut self, node: Node) -> Expr {
        let span = self.span(&node);
        let mut values = self.values(node);
        let commas = known_mistakes::decimal_commas(&values, self.source);
        if !commas.is_empty() {
            self.report(known_mistakes::comma_coordinates(span, &commas, self.source));
            return Expr { kind: ExprKind::Error, span };
        }
        match values.len() {
            1 => Expr { span, ..values.swap_remove(0) },
            2 | 3 => Expr { kind: ExprKind::Tuple(values), span },
            count => {
                self.report(errors::tuple_length(span, count));
                Expr { kind: ExprKind::Error, span }
            }
        }
    }

    fn quantity(&mut self, node: Node) -> ExprKind {
        let mut number = String::new();
        let mut unit = None;
        for part in node.into_inner() {
            match part.as_rule() {
                Rule::number => {
                    number = part.as_str().replace('_', "");
                    if !number.parse::<f64>().is_ok_and(f64::is_finite) {
                        let span = self.span(&part);
                        self.report(errors::number_too_large(span));
                        return ExprKind::Error;
                    }
                }
                Rule::unit => unit = Some(self.ident(&part)),
                _ => return ExprKind::Error,
            }
        }
        match unit {
            Some(unit) => ExprKind::Quantity { number, unit },
            None => ExprKind::Number(number),
        }
    }

    fn named(&mut self, node: Node) -> ExprKind {
        let mut parts = self.children(node).into_iter();
        let Some(path) = parts.next().map(|part| self.path(part)) else { return ExprKind::Error };
        match parts.next() {
            None => ExprKind::Path(path),
            Some(part) if part.as_rule() == Rule::call => {
                ExprKind::Call { function: path, arguments: self.values(part) }
            }
            Some(part) => ExprKind::With { base: path, fields: self.fields(part) },
        }
    }

    /// Reads names joined by dots.
    pub fn path(&mut self, node: Node) -> Path {
        let span = self.span(&node);
        let segments = self.children(node).into_iter().map(|segment| self.indexed(segment)).collect();
        Path { segments, span }
    }

    /// Reads a name with its indices.
    pub fn indexed(&mut self, node: Node) -> IndexedName {
        let span = self.span(&node);
        let mut name = Ident { text: String::new(), span };
        let mut indices = Vec::new();
        for part in self.children(node) {
            match part.as_rule() {
                Rule::index => indices = self.values(part),
                _ => name = self.ident(&part),
            }
        }
        IndexedName { name, indices, span }
    }

    /// Reads the indices in a bracket.
    pub fn indices(&mut self, node: Node) -> Vec<Expr> {
        self.children(node).into_iter().flat_map(|index| self.values(index)).collect()
    }

    /// Reads a string.
    pub fn text(&mut self, node: Node) -> Text {
        let span = self.span(&node);
        let mut parts: Vec<TextPart> = Vec::new();
        for part in node.into_inner() {
            let piece = match part.as_rule() {
                Rule::brace => "{",
                Rule::plain => part.as_str(),
                _ => {
                    parts.push(TextPart::Hole(self.text_hole(part)));
                    continue;
                }
            };
            match parts.last_mut() {
                Some(TextPart::Plain(text)) => text.push_str(piece),
                _ => parts.push(TextPart::Plain(piece.to_owned())),
            }
        }
        Text { parts, span }
    }

    fn text_hole(&mut self, node: Node) -> Expr {
        let span = self.span(&node);
        let source = &self.text[span.range()];
        let source = &source[1..source.len() - 1];
        let outer = std::mem::replace(&mut self.origin.base, span.start as usize + 1);
        let expr = match Grammar::parse(Rule::one_value, source) {
            Ok(mut nodes) => nodes.next().and_then(|node| self.only_value(node)),
            Err(_) => None,
        };
        self.origin.base = outer;
        expr.unwrap_or_else(|| {
            if !source.contains(HOLE) {
                self.report(errors::text_hole(span, source));
            }
            Expr { kind: ExprKind::Error, span }
        })
    }

    /// Reads the value of a fragment that contains nothing else.
    pub fn only_value(&mut self, node: Node) -> Option<Expr> {
        let value = self.children(node).into_iter().find(|child| child.as_rule() == Rule::expr)?;
        Some(self.expr(value))
    }

    fn table(&mut self, node: Node) -> ExprKind {
        let mut columns = Vec::new();
        let mut rows = Vec::new();
        for part in self.children(node) {
            match part.as_rule() {
                Rule::header => match self.header(part) {
                    Some(header) => columns = header,
                    None => return ExprKind::Error,
                },
                Rule::row => {
                    let row = self.row(part, &columns);
                    rows.push(row);
                }
                Rule::bad_row if !Self::has_hole(&part) => {
                    let span = self.span(&part);
                    self.report(errors::bad_row(span, self.source));
                }
                _ => {}
            }
        }
        ExprKind::Table(Table { columns, rows })
    }

    fn header(&mut self, node: Node) -> Option<Vec<Column>> {
        let mut columns = Vec::new();
        for part in self.children(node) {
            if part.as_rule() == Rule::bad_row {
                if !Self::has_hole(&part) {
                    let span = self.span(&part);
                    self.report(errors::bad_header(span));
                }
                return None;
            }
            let mut words = part.into_inner();
            let name = words.next().map(|word| self.ident(&word))?;
            let unit = words.next().map(|unit| self.ident(&unit));
            columns.push(Column { name, unit });
        }
        Some(columns)
    }

    /// Reads a row; it always has as many cells as there are columns.
    fn row(&mut self, node: Node, columns: &[Column]) -> Row {
        let span = self.span(&node);
        let mut parts: Vec<Node> = node.into_inner().collect();
        if self.source[span.range()].starts_with('|') {
            self.report(errors::bar_before_row(span));
            parts.remove(0);
        }
        parts.retain(|part| !self.is_mark(part));
        let mut cells: Vec<Expr> = parts.into_iter().map(|cell| self.primary(cell)).collect();
        if cells.len() != columns.len() {
            self.report(errors::row_length(span, cells.len(), columns));
            cells.resize(columns.len(), Expr { kind: ExprKind::Error, span: span.after() });
        }
        Row { cells, span }
    }

    /// Reads the value of a field or a `let`; the grammar leaves a mark where it is missing.
    pub fn value(&mut self, node: Option<Node>, after: Span) -> Expr {
        match node {
            Some(node) => self.primary(node),
            None => Expr { kind: ExprKind::Error, span: after.after() },
        }
    }

    /// Reads `left: 5`.
    pub fn field(&mut self, node: Node, doc: super::tree::Doc) -> Field {
        let span = self.span(&node);
        let mut parts = self.children(node).into_iter();
        let name = match parts.next() {
            Some(word) => self.ident(&word),
            None => Ident { text: String::new(), span },
        };
        let value = self.value(parts.next(), name.span);
        Field { doc, name, value, span }
    }
}

fn is_operator(rule: Rule) -> bool {
    rule == Rule::minus || operator(rule).is_some() || rule == Rule::range
}

fn join(left: Expr, node: &Node, operator_span: Span, right: Expr) -> Expr {
    let span = left.span.to(right.span);
    let (left, right) = (Box::new(left), Box::new(right));
    let kind = match operator(node.as_rule()) {
        Some(operator) => ExprKind::Binary { left, operator, operator_span, right },
        None => ExprKind::Range { from: left, to: right },
    };
    Expr { kind, span }
}

fn operator(rule: Rule) -> Option<Operator> {
    Some(match rule {
        Rule::eq => Operator::Equal,
        Rule::ne => Operator::NotEqual,
        Rule::lt => Operator::Less,
        Rule::le => Operator::LessEqual,
        Rule::gt => Operator::Greater,
        Rule::ge => Operator::GreaterEqual,
        Rule::add => Operator::Add,
        Rule::sub => Operator::Subtract,
        Rule::mul => Operator::Multiply,
        Rule::div => Operator::Divide,
        Rule::pow => Operator::Power,
        _ => return None,
    })
}

//! PLY.

use super::fields::{Binary, Line, Lines, Number};
use super::header::{Count, Property, Record, Role};
use super::{File, Points};
use crate::io::error::{IoError, IoErrorKind};

/// How the body is written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Binary { big: bool },
}

/// One kind of record of the body.
struct Element {
    is_vertex: bool,
    count: usize,
    record: Record,
}

const FORMATS: &str = "ascii, binary_little_endian or binary_big_endian";
const TYPES: &str = "a type: char, uchar, short, ushort, int, uint, float, double";

pub(super) fn read(file: File<'_>, points: &mut Points) -> Result<(), IoError> {
    let mut lines = Lines::new(file);
    let (encoding, elements) = header(file, &mut lines)?;
    let vertex = elements.iter().find(|element| element.is_vertex);
    let Some((true, spatial)) = vertex.map(|vertex| vertex.record.coordinates()) else {
        return Err(file.fail(IoErrorKind::NoCoordinates));
    };
    points.planar = !spatial;
    // What follows the vertices, faces and the like, is not read.
    match encoding {
        Encoding::Ascii => {
            for Element { is_vertex, count, record } in elements {
                if is_vertex {
                    return record.ascii_records(file, &mut lines, count, |point| points.push(point));
                }
                record.ascii_records(file, &mut lines, count, |_| {})?;
            }
            Ok(())
        }
        Encoding::Binary { big } => {
            let mut bytes = Binary::new(file, lines.at, big);
            for element in elements {
                if element.is_vertex {
                    return element.record.binary_points(&mut bytes, element.count, points);
                }
                bytes.check_room(element.count, element.record.size())?;
                // Nothing is stored of an element without properties.
                for _ in 0..if element.record.properties.is_empty() { 0 } else { element.count } {
                    element.record.binary(&mut bytes)?;
                }
            }
            Ok(())
        }
    }
}

fn header(file: File<'_>, lines: &mut Lines<'_>) -> Result<(Encoding, Vec<Element>), IoError> {
    let (mut encoding, mut elements) = (None, Vec::<Element>::new());
    let mut first = true;
    for mut line in lines {
        line.check_text()?;
        let word = line.word();
        if core::mem::take(&mut first) {
            if word != Some("ply") {
                return Err(line.fail(IoErrorKind::UnknownWord { found: line.found() }, "ply"));
            }
            continue;
        }
        match word {
            Some("format") => encoding = Some(format(&mut line)?),
            Some("element") => {
                let Some(name) = line.word() else { return Err(line.missing("the name of an element")) };
                let count = line.whole("the number of its records")?;
                elements.push(Element { is_vertex: name == "vertex", count, record: Record::default() });
            }
            Some("property") => match elements.last_mut() {
                Some(element) => element.record.properties.push(property(&mut line)?),
                None => {
                    return Err(line.fail(IoErrorKind::UnknownWord { found: line.found() }, "element first"));
                }
            },
            Some("end_header") => match encoding {
                Some(encoding) => return Ok((encoding, elements)),
                None => {
                    return Err(line.fail(IoErrorKind::UnknownWord { found: line.found() }, "format first"));
                }
            },
            None | Some("comment" | "obj_info") => {}
            Some(_) => {
                let expected = "format, element, property, comment, obj_info or end_header";
                return Err(line.fail(IoErrorKind::UnknownWord { found: line.found() }, expected));
            }
        }
    }
    Err(file.fail(IoErrorKind::HeaderOpen { end: "end_header" }))
}

fn format(line: &mut Line<'_>) -> Result<Encoding, IoError> {
    match line.word() {
        Some("ascii") => Ok(Encoding::Ascii),
        Some("binary_little_endian") => Ok(Encoding::Binary { big: false }),
        Some("binary_big_endian") => Ok(Encoding::Binary { big: true }),
        Some(_) => Err(line.fail(IoErrorKind::UnknownWord { found: line.found() }, FORMATS)),
        None => Err(line.missing(FORMATS)),
    }
}

fn property(line: &mut Line<'_>) -> Result<Property, IoError> {
    let listed = line.clone().word() == Some("list");
    let count = if listed {
        line.word();
        Count::Listed(number(line)?)
    } else {
        Count::Fixed(1)
    };
    let number = number(line)?;
    let Some(name) = line.word() else { return Err(line.missing("the name of a property")) };
    let role = if listed { Role::Other } else { Role::of(name) };
    Ok(Property { role, number, count })
}

fn number(line: &mut Line<'_>) -> Result<Number, IoError> {
    match line.word() {
        Some("char" | "int8") => Ok(Number::I8),
        Some("uchar" | "uint8") => Ok(Number::U8),
        Some("short" | "int16") => Ok(Number::I16),
        Some("ushort" | "uint16") => Ok(Number::U16),
        Some("int" | "int32") => Ok(Number::I32),
        Some("uint" | "uint32") => Ok(Number::U32),
        Some("float" | "float32") => Ok(Number::F32),
        Some("double" | "float64") => Ok(Number::F64),
        Some(_) => Err(line.fail(IoErrorKind::UnknownWord { found: line.found() }, TYPES)),
        None => Err(line.missing(TYPES)),
    }
}

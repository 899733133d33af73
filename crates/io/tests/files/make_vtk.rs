//! Writers of VTK image data, XML and legacy.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use isoray_io::{Endian, SampleType};

use crate::make::{SAMPLES, body, text_body, vtk_type, zlib};

/// How the numbers of an array stand in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    Inline,
    AppendedRaw,
    AppendedBase64,
}

/// A compressor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Codec {
    None,
    Zlib,
    Lz4,
}

/// A `.vti` file with one array of points before which an array of the file stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vti {
    pub(crate) sample: SampleType,
    pub(crate) endian: Endian,
    pub(crate) wide: bool,
    pub(crate) encoding: Encoding,
    pub(crate) codec: Codec,
    /// Bytes in a block.
    pub(crate) block: usize,
    pub(crate) components: usize,
}

impl Vti {
    pub(crate) fn new(encoding: Encoding, codec: Codec) -> Self {
        let (sample, endian) = (SampleType::I16, Endian::Big);
        Self { sample, endian, wide: true, encoding, codec, block: 50, components: 1 }
    }

    fn word(&self, n: usize) -> Vec<u8> {
        let mut bytes = (n as u64).to_le_bytes()[..if self.wide { 8 } else { 4 }].to_vec();
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        bytes
    }

    /// The numbers with their header, as bytes or base64 text.
    pub(crate) fn encode(&self, samples: &[u8], base64: bool) -> Vec<u8> {
        let text = |bytes: &[u8]| if base64 { STANDARD.encode(bytes).into_bytes() } else { bytes.to_vec() };
        let pack = |block: &[u8]| match self.codec {
            Codec::Lz4 => lz4_flex::block::compress(block),
            _ => zlib(block),
        };
        if self.codec == Codec::None {
            return text(&[self.word(samples.len()), samples.to_vec()].concat());
        }
        let blocks: Vec<Vec<u8>> = samples.chunks(self.block).map(pack).collect();
        let mut table = [blocks.len(), self.block, samples.len() % self.block].map(|n| self.word(n)).concat();
        blocks.iter().for_each(|b| table.extend(self.word(b.len())));
        [text(&table), text(&blocks.concat())].concat()
    }

    /// The opening tag of the file.
    pub(crate) fn open_tag(&self) -> String {
        let order = if self.endian == Endian::Big { "BigEndian" } else { "LittleEndian" };
        let header = if self.wide { " header_type=\"UInt64\"" } else { "" };
        let compressor = match self.codec {
            Codec::None => "",
            Codec::Zlib => " compressor=\"vtkZLibDataCompressor\"",
            Codec::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
        };
        format!("<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{order}\"{header}{compressor}>\n")
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let samples = body(self.sample, self.endian, self.components, true);
        let time = self.encode(&[1, 2, 3, 4, 5, 6, 7, 8], self.encoding != Encoding::AppendedRaw);
        let (kind, components) = (vtk_type(self.sample), self.components);
        let (format, place) = match self.encoding {
            Encoding::Ascii => ("ascii", String::new()),
            Encoding::Inline => ("binary", String::new()),
            _ => ("appended", format!(" offset=\"{}\"", time.len())),
        };
        let inline = |text: &[u8]| match self.encoding {
            Encoding::Ascii | Encoding::Inline => [b"\n  ", text, b"\n"].concat(),
            _ => vec![],
        };
        let text = if self.encoding == Encoding::Ascii { text_body() } else { self.encode(&samples, true) };
        let first = if place.is_empty() { "" } else { " offset=\"0\"" };
        let field = format!(
            "<ImageData WholeExtent=\"0 4 0 3 0 2\" Origin=\"1 2 3\" Spacing=\"1 2 0.5\">\n <FieldData>\
             <DataArray type=\"UInt8\" Name=\"t\" format=\"{format}\"{first} NumberOfTuples=\"8\">"
        );
        let array = format!(
            "</DataArray></FieldData>\n<Piece Extent=\"0 4 0 3 0 2\"><PointData Scalars=\"s\">\
             <DataArray type=\"{kind}\" Name=\"s\" NumberOfComponents=\"{components}\" format=\"{format}\"{place}>"
        );
        let end = "</DataArray></PointData><CellData></CellData></Piece></ImageData>\n";
        let section = match self.encoding {
            Encoding::AppendedRaw => {
                [b"<AppendedData encoding=\"raw\">\n _", &*time, &self.encode(&samples, false)].concat()
            }
            Encoding::AppendedBase64 => {
                [b"<AppendedData encoding=\"base64\">_", &*time, &self.encode(&samples, true)].concat()
            }
            _ => vec![],
        };
        let close: &[u8] = if section.is_empty() { b"" } else { b"\n</AppendedData>" };
        let numbers =
            if self.encoding == Encoding::Ascii { b"1 2 3 4 5 6 7 8".to_vec() } else { time.clone() };
        [
            b"<?xml version=\"1.0\"?>\n<!-- a > comment -->\n",
            self.open_tag().as_bytes(),
            field.as_bytes(),
            &inline(&numbers),
            array.as_bytes(),
            &inline(&text),
            end.as_bytes(),
            &section,
            close,
            b"</VTKFile>\n",
        ]
        .concat()
    }
}

/// A legacy file up to its attributes.
pub(crate) fn legacy_header(ascii: bool) -> String {
    let encoding = if ascii { "ASCII" } else { "BINARY" };
    format!(
        "# vtk DataFile Version 3.0\na title\n{encoding}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n\
         ORIGIN 1 2 3\nSPACING 1 2 0.5\nPOINT_DATA {SAMPLES}\n"
    )
}

/// The name that legacy files give to a type.
pub(crate) fn legacy_type(sample: SampleType) -> &'static str {
    match sample {
        SampleType::U8 => "unsigned_char",
        SampleType::I8 => "char",
        SampleType::U16 => "unsigned_short",
        SampleType::I16 => "short",
        SampleType::U32 => "unsigned_int",
        SampleType::I32 => "int",
        SampleType::U64 => "vtktypeuint64",
        SampleType::I64 => "long",
        SampleType::F32 => "float",
        SampleType::F64 => "double",
    }
}

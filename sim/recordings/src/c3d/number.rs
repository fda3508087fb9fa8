//! Numbers as the three kinds of processor lay them down.

/// A kind of processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Processor {
    /// Low byte first, IEEE floats.
    Intel,
    /// Low byte first, F floats of a VAX.
    Dec,
    /// High byte first, IEEE floats.
    Mips,
}

impl Processor {
    /// The kind that byte 4 of the parameters names.
    pub(super) fn of(byte: u8) -> Option<Self> {
        match byte {
            84 => Some(Processor::Intel),
            85 => Some(Processor::Dec),
            86 => Some(Processor::Mips),
            _ => None,
        }
    }

    /// The word that two bytes begin with.
    pub(super) fn word(self, bytes: &[u8]) -> u16 {
        match self {
            Processor::Intel | Processor::Dec => u16::from_le_bytes([bytes[0], bytes[1]]),
            Processor::Mips => u16::from_be_bytes([bytes[0], bytes[1]]),
        }
    }

    /// The float that four bytes begin with.
    pub(super) fn float(self, bytes: &[u8]) -> f32 {
        match self {
            Processor::Intel => intel(bytes),
            Processor::Dec => dec(bytes),
            Processor::Mips => mips(bytes),
        }
    }
}

/// IEEE, low byte first.
pub(super) fn intel(bytes: &[u8]) -> f32 {
    f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// IEEE, high byte first.
pub(super) fn mips(bytes: &[u8]) -> f32 {
    f32::from_be_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// F float of a VAX: two words with the low byte first, the upper word before the lower. Its
/// mantissa is one of 0.5 to 1 and its exponent is off by 128, so that it has a quarter of the value
/// which IEEE gives to the same bits. Without exponent it is 0 or, with a sign, no number.
pub(super) fn dec(bytes: &[u8]) -> f32 {
    let bits = u32::from_le_bytes([bytes[2], bytes[3], bytes[0], bytes[1]]);
    match (bits >> 23 & 0xff, bits >> 31) {
        (0, 0) => 0.0,
        (0, _) => f32::NAN,
        (1 | 2, _) => f32::from_bits(bits) * 0.25,
        _ => f32::from_bits(bits - (2 << 23)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_number_three_ways() {
        // 1, -0.5, and 3.1415927 by its bits 0x40490fdb; a VAX has two more in the exponent.
        assert_eq!(dec(&[0x80, 0x40, 0, 0]), 1.0);
        assert_eq!(dec(&[0x00, 0xc0, 0, 0]), -0.5);
        assert_eq!(dec(&[0x49, 0x41, 0xdb, 0x0f]), std::f32::consts::PI);
        assert_eq!(intel(&[0xdb, 0x0f, 0x49, 0x40]), std::f32::consts::PI);
        assert_eq!(mips(&[0x40, 0x49, 0x0f, 0xdb]), std::f32::consts::PI);
        assert_eq!(dec(&[0, 0, 7, 7]), 0.0);
        assert!(dec(&[0, 0x80, 0, 0]).is_nan());
        // The largest, which has no exponent that IEEE would know.
        assert_eq!(dec(&[0xff, 0x7f, 0xff, 0xff]), 1.701_411_7e38);
    }
}

"""From text to syntax trees and back; the vocabulary of CGA."""

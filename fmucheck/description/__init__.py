"""What modelDescription.xml says: read leniently, judged strictly."""

"""Rules about modelDescription.xml, which is read leniently and checked strictly."""

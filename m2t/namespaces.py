"""Namespaces of XML that files of Eclipse use."""

XMI = "http://www.omg.org/XMI"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
ECORE = "http://www.eclipse.org/emf/2002/Ecore"

package org.mrsfi.interop;

import com.google.gson.JsonElement;
import com.google.gson.JsonObject;
import java.io.File;
import java.io.IOException;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import org.eclipse.emf.common.util.URI;
import org.eclipse.emf.ecore.EObject;
import org.eclipse.emf.ecore.EPackage;
import org.eclipse.emf.ecore.InternalEObject;
import org.eclipse.emf.ecore.plugin.EcorePlugin;
import org.eclipse.emf.ecore.resource.Resource;
import org.eclipse.emf.ecore.resource.ResourceSet;
import org.eclipse.emf.ecore.resource.impl.ResourceSetImpl;
import org.eclipse.emf.ecore.xmi.impl.EcoreResourceFactoryImpl;
import org.eclipse.emf.ecore.xmi.impl.XMIResourceFactoryImpl;

/** Loads metamodels and models dynamically, as Eclipse does without generated classes. */
final class Models {

    private final List<EPackage> packages = new ArrayList<>();
    private final Map<URI, URI> projects = new LinkedHashMap<>();

    /**
     * Loads the metamodels of a request, and opens its projects as a workspace would.
     *
     * @param request has the paths of .ecore files under "metamodels", and may have the folders of
     *     projects by name under "projects"
     */
    Models(JsonObject request) {
        if (request.has("projects")) {
            request.getAsJsonObject("projects")
                    .entrySet()
                    .forEach(project -> open(project.getKey(), project.getValue().getAsString()));
        }
        ResourceSet metamodels = resources();
        for (String path : paths(request, "metamodels")) {
            Resource resource = metamodels.getResource(uri(path), true);
            packages.add((EPackage) resource.getContents().get(0));
        }
    }

    /** Returns an empty set of resources that knows the metamodels by namespace. */
    ResourceSet resources() {
        ResourceSet resources = new ResourceSetImpl();
        var factories = resources.getResourceFactoryRegistry().getExtensionToFactoryMap();
        factories.put("ecore", new EcoreResourceFactoryImpl());
        factories.put(Resource.Factory.Registry.DEFAULT_EXTENSION, new XMIResourceFactoryImpl());
        for (EPackage known : packages) {
            resources.getPackageRegistry().put(known.getNsURI(), known);
        }
        return resources;
    }

    /** Loads a file by itself; what it refers to is loaded once somebody asks for it. */
    Resource load(String path) {
        return resources().getResource(inWorkspace(uri(path)), true);
    }

    private void open(String name, String path) {
        URI folder = URI.createURI(uri(path) + "/");
        EcorePlugin.getPlatformResourceMap().put(name, folder);
        projects.put(folder, URI.createPlatformResourceURI(name + "/", true));
    }

    /** Returns the address by which a workspace knows a file of an open project. */
    private URI inWorkspace(URI file) {
        for (var project : projects.entrySet()) {
            URI found = file.replacePrefix(project.getKey(), project.getValue());
            if (found != null) {
                return found;
            }
        }
        return file;
    }

    /** Returns the metamodels in the order of the request. */
    List<EPackage> packages() {
        return packages;
    }

    /** Returns the texts of a list in a request; empty if it is absent. */
    static List<String> paths(JsonObject request, String key) {
        List<String> found = new ArrayList<>();
        if (request.has(key)) {
            for (JsonElement entry : request.getAsJsonArray(key)) {
                found.add(entry.getAsString());
            }
        }
        return found;
    }

    /** Returns the address of a file. */
    static URI uri(String path) {
        try {
            return URI.createFileURI(new File(path).getCanonicalPath());
        } catch (IOException problem) {
            throw new IllegalArgumentException(path + " cannot be resolved", problem);
        }
    }

    /** Returns the place of an object in its file, such as {@code //@robots.0/@sensors.1}. */
    static String path(EObject element) {
        EObject container = element.eContainer();
        if (container == null) {
            return "/";
        }
        String parent = path(container);
        InternalEObject parentObject = (InternalEObject) container;
        String segment = parentObject.eURIFragmentSegment(element.eContainingFeature(), element);
        return parent.equals("/") ? "//" + segment : parent + "/" + segment;
    }
}
